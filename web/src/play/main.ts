import '../base.css';
import './play.css';
import { Game } from './game.ts';

void new Game().start();

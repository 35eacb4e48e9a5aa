import 'maplibre-gl/dist/maplibre-gl.css';
import './base.css';
import './stage.css';
import './panel.css';
import './drawing.css';
import './gallery.css';
import './studio.css';
import { Viewer } from './viewer.ts';

void new Viewer().start();

import { element } from '../dialog.ts';
import { moved, withPoint, withoutPoint, type Curve } from './model.ts';

const NS = 'http://www.w3.org/2000/svg';
const [WIDTH, HEIGHT, MARGIN] = [320, 150, 14];
/** How far an arrow key moves a point. */
const STEP = 0.02;

function svg<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Record<string, string | number>): SVGElementTagNameMap[K] {
  const made = document.createElementNS(NS, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  return made;
}

const px = (distance: number) => MARGIN + distance * (WIDTH - 2 * MARGIN);
const py = (height: number) => HEIGHT - MARGIN - height * (HEIGHT - 2 * MARGIN);

/** A profile as a curve whose points are dragged, or moved with the arrow keys. */
export class CurveEditor {
  readonly element = element('div', { className: 'curve' });
  readonly #picture = svg('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'group', 'aria-label': 'Profile from the crest to the foot' });
  readonly #area = svg('path', { class: 'area' });
  readonly #line = svg('path', { class: 'line' });
  readonly #handles = svg('g', {});
  #curve: Curve = [];

  constructor(readonly change: (curve: Curve, settled: boolean) => void) {
    this.#picture.append(this.#area, this.#line, this.#handles);
    const add = element('button', { type: 'button', id: 'add-curve-point', textContent: 'Add a point' });
    add.addEventListener('click', () => this.#set(withPoint(this.#curve), true));
    this.#picture.addEventListener('dblclick', (event) => this.#set(withPoint(this.#curve, this.#place(event)[0]), true));
    const hint = element('p', { className: 'hint', textContent: 'Drag the points; arrow keys move one, Delete takes it away.' });
    this.element.append(this.#picture, element('div', { className: 'actions' }, add), hint);
  }

  set curve(curve: Curve) {
    this.#curve = curve;
    this.#draw();
  }

  #set(curve: Curve, settled: boolean): void {
    if (curve === this.#curve) return;
    this.#curve = curve;
    this.#draw();
    this.change(curve, settled);
  }

  #place(event: MouseEvent): [number, number] {
    const { left, top, width, height } = this.#picture.getBoundingClientRect();
    const x = ((event.clientX - left) / width) * WIDTH;
    const y = ((event.clientY - top) / height) * HEIGHT;
    return [(x - MARGIN) / (WIDTH - 2 * MARGIN), (HEIGHT - MARGIN - y) / (HEIGHT - 2 * MARGIN)];
  }

  #draw(): void {
    const points = this.#curve.map(([d, h]) => `${px(d).toFixed(1)} ${py(h).toFixed(1)}`);
    this.#line.setAttribute('d', `M${points.join('L')}`);
    this.#area.setAttribute('d', `M${px(0)} ${py(0)}L${points.join('L')}L${px(1)} ${py(0)}Z`);
    while (this.#handles.childElementCount > this.#curve.length) this.#handles.lastElementChild?.remove();
    while (this.#handles.childElementCount < this.#curve.length) this.#handles.append(this.#handle(this.#handles.childElementCount));
    this.#curve.forEach(([distance, height], i) => {
      const handle = this.#handles.children[i];
      const fixed = i === 0 || i === this.#curve.length - 1;
      const said = `Point ${i + 1} of ${this.#curve.length}: ${Math.round(height * 100)} % of the height at ${Math.round(distance * 100)} % of the way`;
      const attributes = { cx: px(distance), cy: py(height), 'aria-label': said, 'aria-disabled': fixed, tabindex: fixed ? -1 : 0 };
      for (const [name, value] of Object.entries(attributes)) handle?.setAttribute(name, String(value));
    });
  }

  #handle(i: number): SVGCircleElement {
    const handle = svg('circle', { r: 8, role: 'button' });
    handle.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
    });
    handle.addEventListener('pointermove', (event) => {
      if (handle.hasPointerCapture(event.pointerId)) this.#set(moved(this.#curve, i, this.#place(event)), false);
    });
    handle.addEventListener('pointerup', () => this.change(this.#curve, true));
    handle.addEventListener('dblclick', (event) => event.stopPropagation());
    handle.addEventListener('keydown', (event) => this.#key(event, i));
    return handle;
  }

  #key(event: KeyboardEvent, i: number): void {
    const [distance, height] = this.#curve[i] ?? [0, 0];
    const steps: Record<string, [number, number]> = {
      ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP],
    };
    const step = steps[event.key];
    if (step) this.#set(moved(this.#curve, i, [distance + step[0], height + step[1]]), true);
    else if (event.key === 'Delete' || event.key === 'Backspace') this.#set(withoutPoint(this.#curve, i), true);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

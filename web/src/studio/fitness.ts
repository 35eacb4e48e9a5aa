import type { GenerationPoint } from '../api.ts';

/** The curve of an evolution as a drawing. */

const NAMESPACE = 'http://www.w3.org/2000/svg';
/** The drawing's own units, and the room for the axes. */
export const CHART = { width: 480, height: 220, left: 44, right: 12, top: 10, bottom: 34 };

function svg(tag: string, attributes: Record<string, string | number>, text?: string): SVGElement {
  const made = document.createElementNS(NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Whole steps of 1, 2 or 5 times a power of ten, about so many up to `most`. */
export function ticks(most: number, count: number): number[] {
  const rough = Math.max(most / count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= rough) ?? rough;
  return Array.from({ length: Math.floor(most / step) + 1 }, (_, i) => i * step);
}

/** Where a score of a generation lies. */
export function place(generation: number, score: number, of: number): [number, number] {
  const { width, height, left, right, top, bottom } = CHART;
  const x = left + ((width - left - right) * generation) / Math.max(of, 1);
  const y = top + (height - top - bottom) * (1 - score);
  return [Number(x.toFixed(1)), Number(y.toFixed(1))];
}

/** At most a point a unit of width is drawn: the best of those that fall together. */
function line(points: readonly GenerationPoint[], of: number, value: (point: GenerationPoint) => number): string {
  const every = Math.max(1, Math.ceil(points.length / CHART.width));
  const drawn = points.filter((_, i) => i % every === 0 || i === points.length - 1);
  return drawn.map((point) => place(point.generation, Math.max(0, value(point)), of).join(',')).join(' ');
}

/** Best and mean score over the generations. */
export class FitnessCurve {
  readonly element = svg('svg', { viewBox: `0 0 ${CHART.width} ${CHART.height}`, class: 'fitness', role: 'img', id: 'evolve-curve' }) as SVGSVGElement;

  show(points: readonly GenerationPoint[], of: number): void {
    const { width, height, left, right, top, bottom } = CHART;
    const end = height - bottom;
    const last = points.at(-1);
    const said = last ? `Best score ${last.best.toFixed(3)}, mean ${last.mean.toFixed(3)} in generation ${last.generation} of ${of}` : 'No generation yet';
    const across = [0, 0.25, 0.5, 0.75, 1].flatMap((score) => {
      const [, y] = place(0, score, of);
      return [svg('line', { class: 'grid', x1: left, x2: width - right, y1: y, y2: y }), svg('text', { x: left - 6, y: y + 4, 'text-anchor': 'end' }, score.toFixed(2))];
    });
    const along = ticks(of, 6).map((generation) => svg('text', { x: place(generation, 0, of)[0], y: end + 14, 'text-anchor': 'middle' }, String(generation)));
    const axes = [
      svg('text', { x: (left + width - right) / 2, y: height - 4, 'text-anchor': 'middle' }, 'Generation'),
      svg('text', { x: 10, y: (top + end) / 2, 'text-anchor': 'middle', transform: `rotate(-90 10 ${(top + end) / 2})` }, 'Score'),
    ];
    const lines = points.length > 0 ? [
      svg('polyline', { class: 'mean', points: line(points, of, ({ mean }) => mean) }),
      svg('polyline', { class: 'best', points: line(points, of, ({ best }) => best) }),
    ] : [];
    const dot = last ? place(last.generation, last.best, of) : undefined;
    this.element.replaceChildren(svg('title', {}, said), ...across, ...along, ...axes, ...lines, ...(dot ? [svg('circle', { class: 'best', cx: dot[0], cy: dot[1], r: 3.5 })] : []));
  }
}

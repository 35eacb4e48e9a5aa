import type { Map as MapLibre } from 'maplibre-gl';
import { spacing } from './mercator.ts';

/**
 * A scale bar in metres of the plane. MapLibre's own one measures on the globe, where a Mercator metre shrinks
 * towards the poles; this plane is flat.
 */
export function showScale(map: MapLibre, element: HTMLElement): void {
  const bar = document.createElement('span');
  const label = document.createElement('span');
  bar.className = 'bar';
  element.append(bar, label);
  const draw = () => {
    const perPixel = spacing(map.getZoom());
    const metres = roundDown(90 * perPixel);
    bar.style.width = `${metres / perPixel}px`;
    label.textContent = metres >= 1000 ? `${metres / 1000} km` : metres >= 1 ? `${metres} m` : `${Math.round(metres * 1000)} mm`;
  };
  map.on('zoom', draw);
  draw();
}

/** The largest 1, 2 or 5 times a power of ten that is not more. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

import {
  BufferAttribute,
  BufferGeometry,
  DataArrayTexture,
  DynamicDrawUsage,
  FloatType,
  Frustum,
  GLSL3,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Matrix4,
  Mesh,
  NearestFilter,
  PerspectiveCamera,
  RGBAFormat,
  RawShaderMaterial,
  Scene,
  Vector3,
  Vector4,
  WebGLRenderer,
  Box3,
  type IUniform,
} from 'three';
import { TEXELS, type Block } from './block.ts';
import { CELLS, sideOf, type Place } from './grid.ts';
import type { Direction } from './ray.ts';
import type { Stop } from './relief.ts';
import { GROUND_FRAGMENT, GROUND_VERTEX, SKY_FRAGMENT, SKY_VERTEX } from './shaders.ts';
import { HORIZON, type Quarter } from './terrain.ts';

/** Layers of the texture that every WebGL 2 has, and how many are wished for: a block each. */
const LAYERS = 320;
/** Most quarters in a picture. */
const MOST = 1024;
const QUARTER = CELLS / 2;
const FIELD_OF_VIEW = 62;
/** What is drawn on the ground counts from the nearest corner of such squares, so that small numbers stay exact. */
const SQUARE = 65_536;
const NEAR_M = 0.25;

/** A circle on the ground. */
export interface Circle {
  place: Place;
  radius: number;
  strength: number;
}

export interface Seen {
  place: Place;
  /** Elevation of the eye, and metres of it above the ground. */
  eye: number;
  above: number;
  heading: number;
  pitch: number;
  seconds: number;
  share: number;
  ring?: Circle | undefined;
  pulse?: Circle | undefined;
}

/** 33 × 33 vertices of a quarter, and under its edges a skirt that hides what neighbours leave open. */
function quarterGeometry(): InstancedBufferGeometry {
  const side = QUARTER + 1;
  const cells: number[] = [];
  for (let row = 0; row < side; row++) for (let column = 0; column < side; column++) cells.push(column, row, 0);
  const indices: number[] = [];
  for (let row = 0; row < QUARTER; row++) {
    for (let column = 0; column < QUARTER; column++) {
      const i = row * side + column;
      indices.push(i, i + side, i + 1, i + 1, i + side, i + side + 1);
    }
  }
  // Round the quarter, so that the skirt's outside is its front.
  const rim: number[] = [];
  for (let i = 0; i < QUARTER; i++) rim.push(i * side);
  for (let i = 0; i < QUARTER; i++) rim.push(QUARTER * side + i);
  for (let i = QUARTER; i > 0; i--) rim.push(i * side + QUARTER);
  for (let i = QUARTER; i > 0; i--) rim.push(i);
  const below = cells.length / 3;
  for (const i of rim) cells.push(cells[3 * i] ?? 0, cells[3 * i + 1] ?? 0, 1);
  rim.forEach((i, n) => {
    const next = (n + 1) % rim.length;
    indices.push(i, below + n, rim[next] ?? 0, rim[next] ?? 0, below + n, below + next);
  });
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute('cell', new BufferAttribute(new Float32Array(cells), 3));
  geometry.setIndex(indices);
  return geometry;
}

function instanced(size: number): InstancedBufferAttribute {
  return new InstancedBufferAttribute(new Float32Array(MOST * size), size).setUsage(DynamicDrawUsage);
}

/** The picture: ground, water and sky, from somebody's eyes. The eye is at the origin of what is drawn, so far places are as exact as near ones. */
export class View {
  readonly renderer: WebGLRenderer;
  readonly layers: number;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, NEAR_M, 1.5 * HORIZON);
  readonly #frustum = new Frustum();
  readonly #viewProjection = new Matrix4();
  readonly #ground: RawShaderMaterial;
  readonly #sky: RawShaderMaterial;
  readonly #quarters = quarterGeometry();
  readonly #place = instanced(4);
  readonly #patch = instanced(3);
  readonly #texel = instanced(2);
  #heights: DataArrayTexture | undefined;
  #ratio = 1;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.layers = Math.min(LAYERS, gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number);
    this.renderer.autoClear = false;
    this.#camera.rotation.order = 'YXZ';
    this.#ground = material(GROUND_VERTEX, GROUND_FRAGMENT, {
      heights: { value: null },
      viewProjection: { value: this.#viewProjection },
      eye: { value: new Vector3() },
      above: { value: 0 },
      share: { value: 1 },
      sea: { value: 0 },
      seconds: { value: 0 },
      haze: { value: 0.62 * HORIZON },
      ring: { value: new Vector4() },
      pulse: { value: new Vector4() },
      snow: { value: 0 },
      colours: { value: [] },
      stops: { value: [] },
    });
    this.#sky = material(SKY_VERTEX, SKY_FRAGMENT, { inverseViewProjection: { value: new Matrix4() }, seconds: { value: 0 } });
    this.#sky.depthWrite = false;
    this.#quarters.setAttribute('place', this.#place);
    this.#quarters.setAttribute('patch_', this.#patch);
    this.#quarters.setAttribute('texel', this.#texel);
    this.#add(this.#quarters, this.#ground, 0);
    const triangle = new BufferGeometry();
    triangle.setAttribute('position', new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    this.#add(triangle, this.#sky, 1); // where no ground was drawn
  }

  #add(geometry: BufferGeometry, drawn: RawShaderMaterial, order: number): void {
    const mesh = new Mesh(geometry, drawn);
    mesh.frustumCulled = false;
    mesh.renderOrder = order;
    this.#scene.add(mesh);
  }

  /** Takes on a world: its heights by layers, its sea and the colours of its land. */
  show(data: Float32Array<ArrayBuffer>, sea: number, stops: readonly Stop[], snow: number): void {
    this.#heights?.dispose();
    this.#heights = new DataArrayTexture(data, TEXELS, TEXELS, data.length / (4 * TEXELS * TEXELS));
    Object.assign(this.#heights, { format: RGBAFormat, type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, unpackAlignment: 4 });
    this.#heights.needsUpdate = true;
    this.#set(this.#ground, {
      heights: this.#heights,
      sea,
      snow,
      colours: stops.map(({ colour }) => new Vector3(...colour)),
      stops: stops.map(({ elevation }) => elevation),
    });
  }

  /** A layer's heights have changed. */
  update(layer: number): void {
    this.#heights?.addLayerUpdate(layer);
    if (this.#heights) this.#heights.needsUpdate = true;
  }

  /** Fits the picture to the canvas; `ratio` is of its pixels to the page's. Answers whether it is to be drawn anew. */
  resize(ratio: number): boolean {
    const { clientWidth, clientHeight } = this.canvas;
    const size = [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)] as const;
    if (size[0] === this.canvas.width && size[1] === this.canvas.height && ratio === this.#ratio) return false;
    this.#ratio = ratio;
    this.renderer.setSize(Math.max(1, size[0]), Math.max(1, size[1]), false);
    this.#camera.aspect = Math.max(1, clientWidth) / Math.max(1, clientHeight);
    // Upright phones see as far to the sides as they can without a fish's eye.
    this.#camera.fov = this.#camera.aspect < 1 ? 76 : FIELD_OF_VIEW;
    this.#camera.updateProjectionMatrix();
    return true;
  }

  /** Looks from somewhere; answers which blocks are in view from there. */
  look({ place, eye, heading, pitch }: Pick<Seen, 'place' | 'eye' | 'heading' | 'pitch'>): (block: Block) => boolean {
    this.#camera.rotation.set(pitch, -heading, 0);
    this.#camera.updateMatrixWorld();
    this.#viewProjection.multiplyMatrices(this.#camera.projectionMatrix, this.#camera.matrixWorldInverse);
    this.#frustum.setFromProjectionMatrix(this.#viewProjection);
    const box = new Box3();
    return ({ address: { x, y }, side, low, high }) => {
      // Below its lowest height a block has its skirt; where the sea is higher it is drawn at the sea's level.
      const sea = this.#uniform('sea');
      const [west, north] = [x * side - place.east, y * side - place.south];
      box.min.set(west, Math.min(low, Math.max(low, sea)) - side / 16 - eye, north);
      box.max.set(west + side, Math.max(high, sea) - eye, north + side);
      return this.#frustum.intersectsBox(box);
    };
  }

  /** Where a point of the picture (0 … 1 from its left and top) lies from the eye. */
  direction([across, down]: readonly [number, number]): Direction {
    const far = new Vector3(2 * across - 1, 1 - 2 * down, 0.5).applyMatrix4(this.#viewProjection.clone().invert()).normalize();
    return { east: far.x, south: far.z, up: far.y };
  }

  /** Where in the picture (0 … 1 from its left and top) a point is, `up` metres above the eye; nowhere if it is behind or aside. */
  point(from: Place, { east, south }: Place, up: number): readonly [number, number] | undefined {
    const at = new Vector4(east - from.east, up, south - from.south, 1).applyMatrix4(this.#viewProjection);
    const [across, down] = [0.5 + 0.5 * (at.x / at.w), 0.5 - 0.5 * (at.y / at.w)];
    return at.w > 0 && Math.abs(across - 0.5) < 0.55 && Math.abs(down - 0.5) < 0.55 ? [across, down] : undefined;
  }

  /** Draws a picture of what `look` has chosen. */
  draw(quarters: readonly Quarter[], refinement: number, seen: Seen): void {
    const { place } = seen;
    const from: Place = { east: Math.round(place.east / SQUARE) * SQUARE, south: Math.round(place.south / SQUARE) * SQUARE };
    const count = Math.min(MOST, quarters.length);
    for (let i = 0; i < count; i++) {
      const { block, corner } = quarters[i] as Quarter;
      const { x, y, z } = block.address;
      const side = sideOf(z);
      this.#place.setXYZW(i, x * side - place.east, y * side - place.south, side / CELLS, refinement * side);
      this.#patch.setXYZ(i, corner[0], corner[1], block.layer);
      this.#texel.setXY(i, x * side - from.east, y * side - from.south);
    }
    for (const attribute of [this.#place, this.#patch, this.#texel]) attribute.needsUpdate = true;
    this.#quarters.instanceCount = count;
    const circle = (c: Circle | undefined) =>
      c ? new Vector4(c.place.east - place.east, c.place.south - place.south, c.radius, c.strength) : new Vector4();
    (this.#ground.uniforms['eye'] as IUniform<Vector3>).value.set(0, seen.eye, 0);
    this.#set(this.#ground, { above: seen.above, share: seen.share, seconds: seen.seconds, ring: circle(seen.ring), pulse: circle(seen.pulse) });
    this.#set(this.#sky, { seconds: seen.seconds });
    (this.#sky.uniforms['inverseViewProjection'] as IUniform<Matrix4>).value.copy(this.#viewProjection).invert();
    this.renderer.clear();
    this.renderer.render(this.#scene, this.#camera);
  }

  #uniform(name: string): number {
    return (this.#ground.uniforms[name] as IUniform<number>).value;
  }

  #set(drawn: RawShaderMaterial, values: Record<string, unknown>): void {
    for (const [name, value] of Object.entries(values)) (drawn.uniforms[name] as IUniform<unknown>).value = value;
  }
}

function material(vertexShader: string, fragmentShader: string, uniforms: Record<string, IUniform<unknown>>): RawShaderMaterial {
  return new RawShaderMaterial({ glslVersion: GLSL3, vertexShader, fragmentShader, uniforms });
}

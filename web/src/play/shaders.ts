/** What the graphics card does (GLSL ES 3.00): the ground with its water, and the sky. Colours are linear until they are written. */

const COMMON = `
precision highp float;
precision highp int;

const vec3 SUN = normalize(vec3(-0.55, 0.62, -0.52)); // a morning in the north-west, as on the map
const vec3 SUNLIGHT = vec3(1.28, 1.16, 0.96);
const vec3 SKYLIGHT = vec3(0.34, 0.45, 0.62);
const vec3 ZENITH = vec3(0.105, 0.265, 0.56);
const vec3 HORIZON = vec3(0.60, 0.73, 0.83);

float hash(vec2 p) {
  uvec2 q = uvec2(ivec2(p)) * uvec2(1597334673u, 3812015801u);
  uint n = (q.x ^ q.y) * 1597334673u;
  return float(n >> 8) * (1.0 / 16777216.0);
}

float value_noise(vec2 p) {
  vec2 cell = floor(p);
  vec2 f = p - cell;
  f = f * f * (3.0 - 2.0 * f);
  float north = mix(hash(cell), hash(cell + vec2(1, 0)), f.x);
  float south = mix(hash(cell + vec2(0, 1)), hash(cell + vec2(1, 1)), f.x);
  return mix(north, south, f.y);
}

vec3 sky_colour(vec3 direction) {
  float up = max(direction.y, 0.0);
  vec3 colour = mix(HORIZON, ZENITH, 1.0 - exp(-3.2 * up));
  float towards = max(dot(direction, SUN), 0.0);
  colour += vec3(1.0, 0.82, 0.55) * (0.10 * pow(towards, 6.0) + 0.18 * pow(towards, 40.0));
  return colour;
}

vec4 finished(vec3 colour) {
  colour = max(colour, 0.0);
  colour = colour * (1.0 + colour * 0.12) / (1.0 + colour * 0.42); // bright things keep their form
  return vec4(pow(colour * 1.12, vec3(1.0 / 2.2)), 1.0);
}
`;

/** Every instance is a quarter of a block: 32 × 32 cells and a skirt below its edges. */
export const GROUND_VERTEX = `
${COMMON}
precision highp sampler2DArray;

uniform sampler2DArray heights;
uniform mat4 viewProjection;
uniform vec3 eye;        // east and south of the frame's origin are 0, up is the elevation
uniform float above;     // metres of the eye above the ground
uniform float share;     // of the way from the heights before to those now
uniform float sea;

in vec3 cell;            // column, row, and 1 in the skirt
in vec4 place;           // metres from the eye to the block's north-west corner, east and south; its spacing; where its parent takes over
in vec3 patch_;          // first cell, and layer
in vec2 texel;           // place of the block's corner in a square of 4096 m, for what is drawn on the ground

out vec3 offset;         // from the eye: east, up, south
out vec3 normal;
out float ground;        // elevation of the ground, also under water
out float hollow;        // metres below what lies around
out vec2 plane;

float morph_at(vec2 from_eye) {
  float far = length(vec3(from_eye, above));
  return clamp((far - 0.72 * place.w) / (0.27 * place.w), 0.0, 1.0);
}

float height_at(ivec2 at, float morph) {
  vec4 four = texelFetch(heights, ivec3(at, int(patch_.z)), 0);
  return mix(mix(four.x, four.y, morph), mix(four.z, four.w, morph), share);
}

void main() {
  ivec2 at = ivec2(cell.xy + patch_.xy) + 1;
  vec2 along = (cell.xy + patch_.xy) * place.z;
  vec2 from_eye = place.xy + along;
  float morph = morph_at(from_eye);
  ground = height_at(at, morph);
  float west = height_at(at - ivec2(1, 0), morph);
  float east = height_at(at + ivec2(1, 0), morph);
  float north = height_at(at - ivec2(0, 1), morph);
  float south = height_at(at + ivec2(0, 1), morph);
  normal = normalize(vec3(west - east, 2.0 * place.z, north - south));
  hollow = (0.25 * (west + east + north + south) - ground) / place.z;
  float surface = max(ground, sea);
  offset = vec3(from_eye.x, surface - eye.y, from_eye.y);
  offset.y -= cell.z * place.z * 3.0;
  plane = texel + along;
  gl_Position = viewProjection * vec4(offset, 1.0);
}
`;

export const GROUND_FRAGMENT = `
${COMMON}
const int STOPS = 7;

uniform vec3 colours[STOPS];   // of the land, from its foot to its top
uniform float stops[STOPS];    // elevations
uniform vec3 eye;
uniform float sea;
uniform float seconds;         // 0 where nothing is to move by itself
uniform float haze;            // metres
uniform vec4 ring;             // east and south of the eye, radius, strength: how far the ground is promised to stay
uniform vec4 pulse;            // east and south of the eye, radius, strength: where somebody shaped it
uniform float snow;            // elevation from which flat ground is white

in vec3 offset;
in vec3 normal;
in float ground;
in float hollow;
in vec2 plane;

out vec4 colour;

vec3 land(float height) {
  vec3 found = colours[0];
  for (int i = 1; i < STOPS; i++) {
    found = mix(found, colours[i], clamp((height - stops[i - 1]) / max(stops[i] - stops[i - 1], 1e-3), 0.0, 1.0));
  }
  return found;
}

/** Brightness of what grows and lies on the ground, about 1, at scales that the distance leaves visible. */
float grain(float far) {
  float sum = 0.0;
  sum += (value_noise(plane / 97.0) - 0.5) * 0.34;
  sum += (value_noise(plane / 23.0 + 7.0) - 0.5) * 0.26 * exp(-far / 2500.0);
  sum += (value_noise(plane / 3.1 + 3.0) - 0.5) * 0.26 * exp(-far / 330.0);
  sum += (value_noise(plane / 0.43 + 5.0) - 0.5) * 0.34 * exp(-far / 24.0);
  return 1.0 + sum;
}

vec3 lit_ground(vec3 n, float far) {
  float wild = mix(value_noise(plane / 900.0 + 11.0), value_noise(plane / 41.0 + 11.0), exp(-far / 2200.0)) - 0.5;
  vec3 albedo = land(ground + wild * 0.04 * (stops[STOPS - 1] - stops[0]));
  float steep = 1.0 - n.y;
  vec3 rock = mix(vec3(0.20, 0.185, 0.175), vec3(0.33, 0.30, 0.27), value_noise(vec2(plane.x * 0.21 + plane.y * 0.05, ground * 0.35)));
  albedo = mix(albedo, rock, smoothstep(0.20, 0.38, steep + wild * 0.10));
  float white = smoothstep(snow - 150.0, snow + 150.0, ground + wild * 330.0 + (value_noise(plane / 4200.0 + 2.0) - 0.5) * 500.0) * (1.0 - smoothstep(0.16, 0.34, steep));
  albedo = mix(albedo, vec3(0.86, 0.89, 0.93), white);
  float shore = 1.0 - smoothstep(0.4, 2.6, ground - sea + wild);
  albedo = mix(albedo, vec3(0.56, 0.49, 0.35), shore * (1.0 - smoothstep(0.1, 0.3, steep)));
  albedo *= grain(far);
  float occluded = clamp(1.0 - 0.55 * hollow, 0.62, 1.12);
  float sun = max(dot(n, SUN), 0.0);
  vec3 bounce = vec3(0.10, 0.085, 0.06) * max(0.0, 0.6 - n.y);
  return albedo * (SUNLIGHT * sun + SKYLIGHT * (0.55 + 0.45 * n.y) * occluded + bounce);
}

vec3 water(vec3 view, vec3 bed, float far) {
  float depth = sea - ground;
  vec2 wave = vec2(0.0);
  float calm = exp(-far / 900.0);
  vec2 p = plane / 5.0 + vec2(seconds * 0.35, seconds * 0.2);
  vec2 q = plane / 1.7 - vec2(seconds * 0.3, seconds * 0.5);
  wave += vec2(value_noise(p + vec2(0.5, 0)) - value_noise(p - vec2(0.5, 0)), value_noise(p + vec2(0, 0.5)) - value_noise(p - vec2(0, 0.5))) * 0.10;
  wave += vec2(value_noise(q + vec2(0.5, 0)) - value_noise(q - vec2(0.5, 0)), value_noise(q + vec2(0, 0.5)) - value_noise(q - vec2(0, 0.5))) * 0.05;
  vec3 n = normalize(vec3(wave.x * calm, 1.0, wave.y * calm));
  vec3 mirrored = reflect(view, n);
  mirrored.y = abs(mirrored.y);
  float fresnel = 0.03 + 0.97 * pow(1.0 - max(dot(-view, n), 0.0), 5.0);
  vec3 deep = mix(vec3(0.06, 0.24, 0.30), vec3(0.012, 0.065, 0.13), 1.0 - exp(-depth / 60.0));
  vec3 body = mix(bed, deep, 1.0 - exp(-depth / 3.0));
  vec3 shine = SUNLIGHT * pow(max(dot(mirrored, SUN), 0.0), 220.0) * 1.6 * calm;
  return mix(body, sky_colour(mirrored), min(fresnel, 0.85)) + shine;
}

/** A line on the ground around a place. */
float circle(vec4 around, float width) {
  float far = distance(offset.xz, around.xy);
  float eye_far = length(offset);
  float facing = max(abs(dot(offset / eye_far, normalize(normal))), 0.1);
  float line = max(width, min(0.0022 * eye_far / facing, 4.0)); // two pixels, also of ground that is seen from aside
  return around.w * (1.0 - smoothstep(0.5 * line, line, abs(far - around.z)));
}

void main() {
  float far = length(offset);
  vec3 view = offset / far;
  vec3 n = normalize(normal);
  vec3 seen = lit_ground(n, far);
  if (ground < sea) seen = water(view, seen * exp(-max(sea - ground, 0.0) * vec3(0.25, 0.09, 0.06)), far);
  seen = mix(seen, vec3(1.0, 0.93, 0.70), 0.5 * circle(ring, 0.35));
  float inside = pulse.w * exp(-abs(distance(offset.xz, pulse.xy) - pulse.z) * 6.0 / max(pulse.z, 1.0));
  seen += vec3(0.95, 0.72, 0.30) * 0.45 * inside;
  // Air is thinner higher up.
  float mean = 0.5 * (eye.y + max(ground, sea)) - sea;
  float air = 1.0 - exp(-pow(far / haze, 1.5) * exp(-max(mean, 0.0) / 5200.0));
  vec3 level = normalize(vec3(view.x, 0.02, view.z));
  colour = finished(mix(seen, sky_colour(level), clamp(air, 0.0, 1.0)));
}
`;

/** One triangle over the whole view. */
export const SKY_VERTEX = `
${COMMON}
uniform mat4 inverseViewProjection;
in vec3 position;
out vec3 direction;
void main() {
  vec4 far = inverseViewProjection * vec4(position.xy, 1.0, 1.0);
  direction = far.xyz / far.w;
  gl_Position = vec4(position.xy, 1.0, 1.0);
}
`;

export const SKY_FRAGMENT = `
${COMMON}
uniform float seconds;
in vec3 direction;
out vec4 colour;
void main() {
  vec3 view = normalize(direction);
  vec3 seen = sky_colour(view);
  float disc = smoothstep(0.99955, 0.99975, dot(view, SUN));
  seen += vec3(4.0, 3.6, 2.8) * disc;
  if (view.y > 0.015) {
    vec2 at = view.xz / (view.y + 0.09) * 1.9 + vec2(seconds * 0.004, seconds * 0.002) + 20.0;
    float cloud = 0.0, weight = 0.5;
    for (int i = 0; i < 5; i++) {
      cloud += weight * value_noise(at);
      at = at * 2.13 + 9.7;
      weight *= 0.5;
    }
    cloud = smoothstep(0.50, 0.80, cloud) * smoothstep(0.015, 0.20, view.y) * 0.72;
    seen = mix(seen, vec3(0.93, 0.94, 0.96) + 0.12 * pow(max(dot(view, SUN), 0.0), 4.0), cloud);
  }
  colour = finished(seen);
}
`;

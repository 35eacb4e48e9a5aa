// A place in 64 bits an axis: cell + part / 2^32. So it is as exact far from the origin as at it.
struct TerranePlace { cell: vec2<i32>, part: vec2<u32> }

// A place in a lattice: the number of its cell in 64 bits, and part / 2^32 of a cell.
struct TerraneSpot { high: vec2<u32>, low: vec2<u32>, part: vec2<u32> }

// The two halves of 64-bit products.
struct TerraneWide { high: vec2<u32>, low: vec2<u32> }

// One octave: cells a unit (x + y / 2^32 + z / 2^64), phase (of 2^32), seed of its corners, and its weight.
struct TerraneLattice { frequency: vec3<u32>, phase: vec2<u32>, seed: u32, weight: f32 }

// Where a < b, 1: as a carry.
fn terrane_less(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(u32(a.x < b.x), u32(a.y < b.y));
}

fn terrane_wide(a: vec2<u32>, b: u32) -> TerraneWide {
    let mask: vec2<u32> = vec2<u32>(0xffffu);
    let bits: vec2<u32> = vec2<u32>(16u);
    let a_low: vec2<u32> = a & mask;
    let a_high: vec2<u32> = a >> bits;
    let b_low: vec2<u32> = vec2<u32>(b & 0xffffu);
    let b_high: vec2<u32> = vec2<u32>(b >> 16u);
    let first: vec2<u32> = a_high * b_low + ((a_low * b_low) >> bits);
    let second: vec2<u32> = a_low * b_high + (first & mask);
    return TerraneWide(a_high * b_high + (first >> bits) + (second >> bits), a * vec2<u32>(b));
}

fn terrane_sum(a: TerraneSpot, b: TerraneSpot) -> TerraneSpot {
    let part: vec2<u32> = a.part + b.part;
    let low: vec2<u32> = a.low + b.low;
    let carried: vec2<u32> = low + terrane_less(part, a.part);
    return TerraneSpot(a.high + b.high + terrane_less(low, a.low) + terrane_less(carried, low), carried, part);
}

// A place times a factor of x + y / 2^32 + z / 2^64.
fn terrane_times(at: TerranePlace, factor: vec3<u32>) -> TerraneSpot {
    let zero: vec2<u32> = vec2<u32>(0u);
    let cell: vec2<u32> = vec2<u32>(at.cell);
    let whole: TerraneWide = terrane_wide(cell, factor.x);
    let fine: TerraneWide = terrane_wide(cell, factor.y);
    let finest: TerraneWide = terrane_wide(cell, factor.z);
    let part: TerraneWide = terrane_wide(at.part, factor.x);
    let fine_part: TerraneWide = terrane_wide(at.part, factor.y);
    var spot: TerraneSpot = terrane_sum(TerraneSpot(whole.high, whole.low, zero), TerraneSpot(zero, fine.high, fine.low));
    spot = terrane_sum(spot, TerraneSpot(zero, part.high, part.low));
    spot = terrane_sum(spot, TerraneSpot(zero, zero, finest.high));
    spot = terrane_sum(spot, TerraneSpot(zero, zero, fine_part.high));
    // A negative cell was taken for 2^32 more: minus the factor, in two's complement.
    let negative: vec2<u32> = cell >> vec2<u32>(31u);
    let mask: vec2<u32> = zero - negative;
    let minus: TerraneSpot = TerraneSpot(mask & vec2<u32>(~factor.x), mask & vec2<u32>(~factor.y), mask & vec2<u32>(~factor.z));
    return terrane_sum(spot, terrane_sum(minus, TerraneSpot(zero, zero, negative)));
}

fn terrane_locate(at: TerranePlace, lattice: TerraneLattice) -> TerraneSpot {
    return terrane_sum(terrane_times(at, lattice.frequency), TerraneSpot(vec2<u32>(0u), vec2<u32>(0u), lattice.phase));
}

// The place of exact coordinates, |p| < 2^31.
fn terrane_place(p: vec2<f32>) -> TerranePlace {
    let size: vec2<f32> = min(abs(p), vec2<f32>(2147483520.0));
    let whole: vec2<f32> = floor(size);
    let part: vec2<u32> = vec2<u32>((size - whole) * 4294967296.0);
    let negative: vec2<u32> = vec2<u32>(u32(p.x < 0.0), u32(p.y < 0.0));
    let mask: vec2<u32> = vec2<u32>(0u) - negative;
    let signed_part: vec2<u32> = (part ^ mask) + negative;
    let carry: vec2<u32> = terrane_less(signed_part, negative);
    return TerranePlace(vec2<i32>((vec2<u32>(whole) ^ mask) + carry), signed_part);
}

fn terrane_joined(a: TerranePlace, b: TerranePlace) -> TerranePlace {
    let part: vec2<u32> = a.part + b.part;
    return TerranePlace(a.cell + b.cell + vec2<i32>(terrane_less(part, a.part)), part);
}

fn terrane_moved(at: TerranePlace, by: vec2<f32>) -> TerranePlace {
    return terrane_joined(at, terrane_place(by));
}

// The coordinates of a place as plain numbers.
fn terrane_numbers(at: TerranePlace) -> vec2<f32> {
    let negative: vec2<u32> = vec2<u32>(at.cell) >> vec2<u32>(31u);
    let mask: vec2<u32> = vec2<u32>(0u) - negative;
    let part: vec2<u32> = (at.part ^ mask) + negative;
    let cell: vec2<u32> = (vec2<u32>(at.cell) ^ mask) + terrane_less(part, negative);
    let size: vec2<f32> = vec2<f32>(cell) + vec2<f32>(part) * 2.3283064365386963e-10;
    return size * (vec2<f32>(1.0) - 2.0 * vec2<f32>(negative));
}

fn terrane_fraction(part: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(part) * 2.3283064365386963e-10;
}

// In -1/2 ... 1/2 of a period, around a centre.
fn terrane_around(at: TerranePlace, periods: vec3<u32>) -> vec2<f32> {
    return vec2<f32>(vec2<i32>(terrane_times(at, periods).part)) * 2.3283064365386963e-10;
}

fn terrane_frequency(lattice: TerraneLattice) -> f32 {
    return f32(lattice.frequency.x) + f32(lattice.frequency.y) * 2.3283064365386963e-10;
}

// The 32 random bits of the lattice corner a few cells from a spot's own.
fn terrane_corner(spot: TerraneSpot, by: vec2<i32>, seed: u32) -> u32 {
    let cells: vec2<u32> = vec2<u32>(by);
    let low: vec2<u32> = spot.low + cells;
    let high: vec2<u32> = spot.high + terrane_less(low, cells) - (cells >> vec2<u32>(31u));
    let column: u32 = (low.x * 0x9e3779b1u) ^ (high.x * 0x27d4eb2fu);
    let row: u32 = (low.y * 0x85ebca77u) ^ (high.y * 0xc2b2ae3du) ^ seed;
    var bits: u32 = column ^ row;
    bits = (bits ^ (bits >> 16u)) * 0x21f0aaadu;
    bits = (bits ^ (bits >> 15u)) * 0xd35a2d97u;
    return bits ^ (bits >> 15u);
}

// One of 16 unit vectors at odd multiples of 11.25 degrees.
fn terrane_unit_gradient(bits: u32) -> vec2<f32> {
    let n: u32 = bits >> 28u;
    var g: vec2<f32> = vec2<f32>(0.98078525, 0.19509032);
    if (((n + 1u) & 2u) != 0u) { g = vec2<f32>(0.8314696, 0.55557024); }
    if ((n & 2u) != 0u) { g = g.yx; }
    if ((n & 4u) != 0u) { g = vec2<f32>(-g.y, g.x); }
    if ((n & 8u) != 0u) { g = -g; }
    return g;
}

// One of the 12 edges of a cube, seen from above.
fn terrane_edge_gradient(bits: u32) -> vec2<f32> {
    let n: u32 = ((bits >> 16u) * 12u) >> 16u;
    let a: f32 = 1.0 - 2.0 * f32(n & 1u);
    let b: f32 = 1.0 - f32(n & 2u);
    if (n < 4u) { return vec2<f32>(a, b); }
    if (n < 8u) { return vec2<f32>(a, 0.0); }
    return vec2<f32>(0.0, a);
}

// Value and derivatives (by lattice units) of what four corners' gradients blend to, f in the cell, w the fade and dw its derivative.
fn terrane_blend(sw: vec2<f32>, se: vec2<f32>, nw: vec2<f32>, ne: vec2<f32>, f: vec2<f32>, w: vec2<f32>, dw: vec2<f32>) -> vec3<f32> {
    let a: f32 = dot(sw, f);
    let b: f32 = dot(se, f - vec2<f32>(1.0, 0.0)) - a;
    let c: f32 = dot(nw, f - vec2<f32>(0.0, 1.0));
    let d: f32 = dot(ne, f - vec2<f32>(1.0, 1.0)) - c;
    let south: f32 = a + w.x * b;
    let across: f32 = (c + w.x * d) - south;
    let south_slope: vec2<f32> = sw + w.x * (se - sw);
    let north_slope: vec2<f32> = nw + w.x * (ne - nw);
    let slope: vec2<f32> = south_slope + w.y * (north_slope - south_slope) + dw * vec2<f32>(b + w.y * (d - b), across);
    return vec3<f32>(south + w.y * across, slope);
}

// Perlin 1985: value and derivatives by programme units.
fn terrane_o_perlin(at: TerranePlace, lattice: TerraneLattice) -> vec3<f32> {
    let spot: TerraneSpot = terrane_locate(at, lattice);
    let f: vec2<f32> = terrane_fraction(spot.part);
    let sw: vec2<f32> = terrane_unit_gradient(terrane_corner(spot, vec2<i32>(0, 0), lattice.seed));
    let se: vec2<f32> = terrane_unit_gradient(terrane_corner(spot, vec2<i32>(1, 0), lattice.seed));
    let nw: vec2<f32> = terrane_unit_gradient(terrane_corner(spot, vec2<i32>(0, 1), lattice.seed));
    let ne: vec2<f32> = terrane_unit_gradient(terrane_corner(spot, vec2<i32>(1, 1), lattice.seed));
    let blend: vec3<f32> = terrane_blend(sw, se, nw, ne, f, f * f * (3.0 - 2.0 * f), 6.0 * f * (1.0 - f));
    return 1.4142135 * vec3<f32>(blend.x, terrane_frequency(lattice) * blend.yz);
}

// Perlin 2002: value and derivatives by programme units.
fn terrane_i_perlin(at: TerranePlace, lattice: TerraneLattice) -> vec3<f32> {
    let spot: TerraneSpot = terrane_locate(at, lattice);
    let f: vec2<f32> = terrane_fraction(spot.part);
    let sw: vec2<f32> = terrane_edge_gradient(terrane_corner(spot, vec2<i32>(0, 0), lattice.seed));
    let se: vec2<f32> = terrane_edge_gradient(terrane_corner(spot, vec2<i32>(1, 0), lattice.seed));
    let nw: vec2<f32> = terrane_edge_gradient(terrane_corner(spot, vec2<i32>(0, 1), lattice.seed));
    let ne: vec2<f32> = terrane_edge_gradient(terrane_corner(spot, vec2<i32>(1, 1), lattice.seed));
    let fade: vec2<f32> = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let blend: vec3<f32> = terrane_blend(sw, se, nw, ne, f, fade, 30.0 * f * f * (f * (f - 2.0) + 1.0));
    return vec3<f32>(blend.x, terrane_frequency(lattice) * blend.yz);
}

// What one corner adds to Blender's noise: its gradient under the kernel 1 - 3 r^2 + 2 r^3.
fn terrane_blender_corner(spot: TerraneSpot, by: vec2<i32>, seed: u32, f: vec2<f32>) -> vec3<f32> {
    let g: vec2<f32> = terrane_unit_gradient(terrane_corner(spot, by, seed));
    let d: vec2<f32> = f - vec2<f32>(by);
    let square: f32 = dot(d, d);
    if (square >= 1.0) { return vec3<f32>(0.0); }
    let r: f32 = sqrt(square);
    let kernel: f32 = (1.0 - 3.0 * square) + 2.0 * (square * r);
    let along: f32 = dot(g, d);
    return vec3<f32>(kernel * along, kernel * g + along * 6.0 * (r - 1.0) * d);
}

// What brings the greatest value of Blender's noise to 1.
const TERRANE_BLENDER_SCALE: f32 = 1.735427;

// Blender's noise: value and derivatives by programme units.
fn terrane_blender(at: TerranePlace, lattice: TerraneLattice) -> vec3<f32> {
    let spot: TerraneSpot = terrane_locate(at, lattice);
    let f: vec2<f32> = terrane_fraction(spot.part);
    let south: vec3<f32> = terrane_blender_corner(spot, vec2<i32>(0, 0), lattice.seed, f) + terrane_blender_corner(spot, vec2<i32>(1, 0), lattice.seed, f);
    let north: vec3<f32> = terrane_blender_corner(spot, vec2<i32>(0, 1), lattice.seed, f) + terrane_blender_corner(spot, vec2<i32>(1, 1), lattice.seed, f);
    let sum: vec3<f32> = TERRANE_BLENDER_SCALE * (south + north);
    return vec3<f32>(sum.x, terrane_frequency(lattice) * sum.yz);
}

// One value a cell, in 0 ... 1.
fn terrane_cell_noise(at: TerranePlace, lattice: TerraneLattice) -> f32 {
    let spot: TerraneSpot = terrane_locate(at, lattice);
    return f32(terrane_corner(spot, vec2<i32>(0, 0), lattice.seed) >> 8u) * 5.9604644775390625e-8;
}

// The point of a cell, from the cell's corner.
fn terrane_point(bits: u32) -> vec2<f32> {
    return (vec2<f32>(f32(bits & 0xffffu), f32(bits >> 16u)) + 0.5) * 1.52587890625e-5;
}

// The four least of five.
fn terrane_nearest(d: vec4<f32>, more: f32) -> vec4<f32> {
    return vec4<f32>(min(d.x, more), min(d.y, max(d.x, more)), min(d.z, max(d.y, more)), min(d.w, max(d.z, more)));
}

// The product of two values with their derivatives.
fn terrane_product(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(a.x * b.x, a.x * b.yz + b.x * a.yz);
}

// What is not finite becomes 0. By its bits: shaders may take it for granted that all numbers are finite.
fn terrane_finite(a: f32) -> f32 {
    if ((bitcast<u32>(a) & 0x7f800000u) == 0x7f800000u) { return 0.0; }
    return a;
}

// 2 / pi after 32 zero bits.
const TERRANE_TWO_OVER_PI: array<u32, 9> = array<u32, 9>(0x0u, 0xa2f9836eu, 0x4e441529u, 0xfc2757d1u, 0xf534ddc0u, 0xdb629599u, 0x3c439041u, 0xfe5163abu, 0xdebbc561u);

fn terrane_bits_of_two_over_pi(start: i32) -> u32 {
    let word: i32 = start >> 5u;
    let shift: u32 = u32(start) & 31u;
    if (shift == 0u) { return TERRANE_TWO_OVER_PI[word]; }
    return (TERRANE_TWO_OVER_PI[word] << shift) | (TERRANE_TWO_OVER_PI[word + 1] >> (32u - shift));
}

// An angle less its quadrants, and their number (Payne and Hanek 1983): exact for the greatest angles too.
fn terrane_reduced(angle: f32) -> vec2<f32> {
    let size: f32 = abs(angle);
    if (size <= 0.7853981) { return vec2<f32>(angle, 0.0); }
    let bits: u32 = bitcast<u32>(size);
    let mantissa: vec2<u32> = vec2<u32>((bits & 0x7fffffu) | 0x800000u);
    let start: i32 = i32(bits >> 23u) - 120;
    let a: TerraneWide = terrane_wide(mantissa, terrane_bits_of_two_over_pi(start));
    let b: TerraneWide = terrane_wide(mantissa, terrane_bits_of_two_over_pi(start + 32));
    let c: TerraneWide = terrane_wide(mantissa, terrane_bits_of_two_over_pi(start + 64));
    let low: u32 = b.low.x + c.high.x;
    let high: u32 = a.low.x + b.high.x + u32(low < b.low.x);
    let turned: f32 = f32(i32((high << 2u) | (low >> 30u))) + f32(low << 2u) * 2.3283064365386963e-10;
    let rest: f32 = turned * 3.657291804292595e-10;
    let quadrant: f32 = f32(((high + 0x20000000u) >> 30u) & 3u);
    if (angle < 0.0) { return vec2<f32>(-rest, 4.0 - quadrant); }
    return vec2<f32>(rest, quadrant);
}

fn terrane_sine_series(x: f32) -> f32 {
    let z: f32 = x * x;
    return x + x * z * (-0.16666655 + z * (0.008332161 - z * 0.00019515296));
}

fn terrane_cosine_series(x: f32) -> f32 {
    let z: f32 = x * x;
    return 1.0 - 0.5 * z + z * z * (0.041666646 + z * (-0.0013887316 + z * 0.000024433157));
}

fn terrane_sine_of_quadrant(rest: f32, quadrant: u32) -> f32 {
    var value: f32 = terrane_sine_series(rest);
    if ((quadrant & 1u) != 0u) { value = terrane_cosine_series(rest); }
    if ((quadrant & 2u) != 0u) { value = -value; }
    return value;
}

fn terrane_sin(angle: f32) -> f32 {
    let reduced: vec2<f32> = terrane_reduced(angle);
    return terrane_sine_of_quadrant(reduced.x, u32(reduced.y));
}

fn terrane_cos(angle: f32) -> f32 {
    let reduced: vec2<f32> = terrane_reduced(angle);
    return terrane_sine_of_quadrant(reduced.x, u32(reduced.y) + 1u);
}

fn terrane_tan(angle: f32) -> f32 {
    let reduced: vec2<f32> = terrane_reduced(angle);
    let quadrant: u32 = u32(reduced.y);
    return terrane_finite(terrane_sine_of_quadrant(reduced.x, quadrant) / terrane_sine_of_quadrant(reduced.x, quadrant + 1u));
}

fn terrane_atan(a: f32) -> f32 {
    var x: f32 = abs(a);
    var angle: f32 = 0.0;
    if (x > 2.4142135) {
        angle = 1.5707964;
        x = -1.0 / x;
    } else if (x > 0.41421357) {
        angle = 0.7853982;
        x = (x - 1.0) / (x + 1.0);
    }
    let z: f32 = x * x;
    angle += x + x * z * (-0.3333295 + z * (0.1997771 + z * (-0.13877685 + z * 0.080537446)));
    if (a < 0.0) { return -angle; }
    return angle;
}

// The logarithm of a > 0.
fn terrane_ln(a: f32) -> f32 {
    let bits: u32 = bitcast<u32>(a);
    let exponent: i32 = i32(bits - 0x3f3504f3u) >> 23u;
    let x: f32 = bitcast<f32>(bits - (u32(exponent) << 23u)) - 1.0;
    let z: f32 = x * x;
    var series: f32 = 0.070376836;
    series = series * x - 0.1151461;
    series = series * x + 0.116769984;
    series = series * x - 0.12420141;
    series = series * x + 0.14249323;
    series = series * x - 0.16668057;
    series = series * x + 0.20000714;
    series = series * x - 0.24999994;
    series = series * x + 0.3333333;
    let e: f32 = f32(exponent);
    return (x + (x * z * series - 0.00021219444 * e - 0.5 * z)) + 0.693359375 * e;
}

// e to the power of a, -103 ... 88.72.
fn terrane_exp(a: f32) -> f32 {
    let x: f32 = max(a, -103.0);
    let n: f32 = floor(x * 1.442695 + 0.5);
    let r: f32 = (x - n * 0.693359375) + n * 0.00021219444;
    var series: f32 = 0.00019875691;
    series = series * r + 0.0013981999;
    series = series * r + 0.008333452;
    series = series * r + 0.041665796;
    series = series * r + 0.16666667;
    series = series * r + 0.5;
    // In two factors: 2^128 and 2^-149 are no numbers of their own.
    let whole: i32 = i32(n);
    let first: i32 = whole / 2;
    let scale: f32 = bitcast<f32>(u32(first + 127) << 23u);
    return ((r + r * r * series) + 1.0) * scale * bitcast<f32>(u32(whole - first + 127) << 23u);
}

// Protected: 0 if a = 0.
fn terrane_log(a: f32) -> f32 {
    if (abs(a) < 1.1754944e-38) { return 0.0; }
    return terrane_ln(abs(a));
}

// Protected: 0 where the power is not a number or infinite.
fn terrane_power(a: f32, b: f32) -> f32 {
    if (b == 0.0 || a == 1.0) { return 1.0; }
    let size: f32 = abs(a);
    if (size < 1.1754944e-38) { return 0.0; }
    let exponent: f32 = b * terrane_ln(size);
    if (exponent > 88.72283) { return 0.0; }
    let value: f32 = terrane_exp(exponent);
    if (a > 0.0) { return value; }
    if (floor(b) != b) { return 0.0; }
    if (floor(b * 0.5) != b * 0.5) { return -value; }
    return value;
}

// Protected: a if b = 0.
fn terrane_divide(a: f32, b: f32) -> f32 {
    if (b == 0.0) { return a; }
    return terrane_finite(a / b);
}

// Protected: 0 if b = 0.
fn terrane_mod(a: f32, b: f32) -> f32 {
    if (b == 0.0) { return 0.0; }
    return terrane_finite(a - b * floor(a / b));
}

fn terrane_select(mask: f32, a: f32, b: f32) -> f32 {
    if (mask > 0.0) { return a; }
    return b;
}

// n steps a unit; a riser takes the last 1 - sharpness of each.
fn terrane_terrace(h: f32, n: f32, sharpness: f32) -> f32 {
    let t: f32 = n * h;
    let below: f32 = floor(t);
    let r: f32 = clamp((t - below - sharpness) / (1.0 - sharpness), 0.0, 1.0);
    return terrane_finite((below + r * r * (3.0 - 2.0 * r)) / n);
}

fn terrane_terrace_slope(h: f32, n: f32, sharpness: f32) -> f32 {
    let t: f32 = n * h;
    let r: f32 = clamp((t - floor(t) - sharpness) / (1.0 - sharpness), 0.0, 1.0);
    return terrane_finite(6.0 * r * (1.0 - r) / (1.0 - sharpness));
}

// From 0 to 1 at t = 0, over a width.
fn terrane_rise(t: f32, width: f32) -> f32 {
    if (width <= 0.0) { return f32(t >= 0.0); }
    let r: f32 = clamp(t / width + 0.5, 0.0, 1.0);
    return r * r * (3.0 - 2.0 * r);
}

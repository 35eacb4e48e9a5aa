// What runs in the page: a shader at the points of a square lattice. Each function is sent to the page as text, so it stands alone.

/** The values as a fragment shader renders them into 32-bit floats. */
export function runWebGl({ source, west, north, side, spacing, call = 'terrane_elevation_at(metres, vec2(0.0))' }) {
  const gl = new OffscreenCanvas(side, side).getContext('webgl2');
  if (!gl?.getExtension('EXT_color_buffer_float')) return { skip: 'no WebGL 2 with float render targets' };
  const compile = (kind, text) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`${gl.getShaderInfoLog(shader)}\n${text}`);
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, `#version 300 es
    void main() { gl_Position = vec4(vec2[3](vec2(-1, -1), vec2(3, -1), vec2(-1, 3))[gl_VertexID], 0.0, 1.0); }`));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, `#version 300 es
${source}
uniform ivec2 corner;
out vec4 result;
void main() {
  ivec2 metres = corner + ivec2(1, -1) * ${spacing} * ivec2(gl_FragCoord.xy);
  result = vec4(${call}, 0.0, 0.0, 1.0);
}`));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, side, side);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  gl.viewport(0, 0, side, side);
  gl.useProgram(program);
  gl.uniform2i(gl.getUniformLocation(program, 'corner'), west, north);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const pixels = new Float32Array(side * side * 4);
  gl.readPixels(0, 0, side, side, gl.RGBA, gl.FLOAT, pixels);
  const error = gl.getError();
  gl.getExtension('WEBGL_lose_context').loseContext();
  if (error !== 0) throw new Error(`WebGL error ${error}`);
  return { values: Array.from({ length: side * side }, (_, i) => pixels[4 * i]) };
}

/** The values as a compute shader writes them. */
export async function runWebGpu({ source, west, north, side, spacing, probe = false }) {
  const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
  if (!adapter) return { skip: navigator.gpu ? 'the browser has no WebGPU adapter' : 'the browser has no navigator.gpu' };
  const device = globalThis.terraneDevice ??= await adapter.requestDevice();
  if (probe) return { values: [] };
  const module = device.createShaderModule({ code: `${source}
@group(0) @binding(0) var<storage, read_write> result: array<f32>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= ${side * side}u) { return; }
  let metres = vec2<i32>(${west}, ${north}) + vec2<i32>(1, -1) * ${spacing} * vec2<i32>(i32(id.x % ${side}u), i32(id.x / ${side}u));
  result[id.x] = terrane_elevation_at(metres, vec2<f32>(0.0));
}` });
  const problems = (await module.getCompilationInfo()).messages.filter(({ type }) => type === 'error');
  if (problems.length > 0) throw new Error(problems.map(({ lineNum, message }) => `${lineNum}: ${message}`).join('\n') + source);
  const pipeline = await device.createComputePipelineAsync({ layout: 'auto', compute: { module, entryPoint: 'main' } });
  const size = side * side * 4;
  const buffer = device.createBuffer({ size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC });
  const readable = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: [{ binding: 0, resource: { buffer } }] }));
  pass.dispatchWorkgroups(Math.ceil(side * side / 64));
  pass.end();
  encoder.copyBufferToBuffer(buffer, 0, readable, 0, size);
  device.queue.submit([encoder.finish()]);
  await readable.mapAsync(GPUMapMode.READ);
  const values = Array.from(new Float32Array(readable.getMappedRange()));
  buffer.destroy();
  readable.destroy();
  return { values };
}

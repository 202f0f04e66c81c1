// SPDX-License-Identifier: GPL-3.0-or-later
// The shaders: those of lumatlas' own renderer, and the page's. Counterpart of blend/shader_program.cpp.

// In the order of TextureUnit there; the page's own after them.
export const SAMPLERS = [
  'photographs', 'depths', 'surfaces', 'zones', 'cells', 'references', 'views', 'tile_slots', 'image', 'mask',
  'diagnosis', 'seen_depths',
];
export const unitOf = (name) => SAMPLERS.indexOf(name);

const PASSES = {
  surface: {vertex: 'surface.vert', fragment: 'surface.frag'},
  silhouettes: {fragment: 'silhouettes.frag'},
  blend: {fragment: 'blend.frag'},
  samples: {fragment: 'blend.frag', defines: '#define SAMPLES\n'},
  diagnose: {fragment: 'diagnose.frag'},
  depth: {fragment: 'depth.frag'},
  photograph: {fragment: 'photograph.frag'},
  bc7: {fragment: 'bc7.frag'},
  etc2: {fragment: 'etc2.frag'},
  needs: {fragment: 'needs.frag'},
  present: {fragment: 'page.frag'},
  modes: {fragment: 'modes.frag'},
  fade: {fragment: 'fade.frag'},
  glance: {fragment: 'glance.frag'},
};

// Compiled in the background where the browser can; a pass whose program is not ready() is not drawn yet.
export class Programs {
  // `views`: how many are blended at a pixel.
  constructor(gl, shaders, views) {
    this.gl = gl;
    this.shaders = shaders;
    this.views = views;
    this.parallel = gl.getExtension('KHR_parallel_shader_compile');
    this.programs = new Map();
  }

  entry(pass, cells = 0) {
    const key = `${pass} ${cells}`;
    if (!this.programs.has(key)) this.programs.set(key, this.started(pass, cells));
    return this.programs.get(key);
  }

  ready(pass, cells = 0) {
    const entry = this.entry(pass, cells);
    if (entry.linked || !this.parallel) return true;
    return this.gl.getProgramParameter(entry.program, this.parallel.COMPLETION_STATUS_KHR);
  }

  // Waits for it, if need be, and makes it current.
  use(pass, cells = 0) {
    const entry = this.entry(pass, cells);
    if (!entry.linked) this.finish(entry);
    this.gl.useProgram(entry.program);
    return entry;
  }

  started(pass, cells) {
    const {gl} = this;
    const {definitions: ofAll, sources} = this.shaders;
    const {vertex = 'screen.vert', fragment, defines = ''} = PASSES[pass];
    const definitions = ofAll + `#define BLENDED_VIEWS ${this.views}\n` +
        (cells ? `#define CELLS ${cells}\n` : '') + defines;
    const program = gl.createProgram();
    const shaders = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].map(([type, name]) => {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, sources[name].replace('\n', '\n' + definitions));  // after the version
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      return shader;
    });
    gl.linkProgram(program);
    return {pass, program, shaders, linked: false, uniforms: new Map()};
  }

  finish(entry) {
    const {gl} = this;
    const {program, shaders, pass} = entry;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = shaders.map((shader) => gl.getShaderInfoLog(shader)).filter(Boolean);
      throw new Error(`the shader "${pass}" does not compile: ${[...logs, gl.getProgramInfoLog(program)].join(' ')}`);
    }
    shaders.forEach((shader) => gl.deleteShader(shader));
    const block = gl.getUniformBlockIndex(program, 'Picture');
    if (block !== gl.INVALID_INDEX) gl.uniformBlockBinding(program, block, 0);
    gl.useProgram(program);
    SAMPLERS.forEach((name, unit) => {
      const location = gl.getUniformLocation(program, name);
      if (location) gl.uniform1i(location, unit);
    });
    entry.uniform = (name) => {
      if (!entry.uniforms.has(name)) entry.uniforms.set(name, gl.getUniformLocation(program, name));
      return entry.uniforms.get(name);
    };
    entry.linked = true;
  }
}

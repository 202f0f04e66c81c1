// SPDX-License-Identifier: GPL-3.0-or-later
// The shaders: those of lumatlas' own renderer, and the page's. Counterpart of blend/gl/shader_program.cpp.
import {ContextLost, GlObjects} from './gl_objects.js';
/** @import {Shaders} from '../types.d.ts' */

// In the order of TextureUnit there; the page's own after them.
const SAMPLERS = [
  'photographs', 'depths', 'surfaces', 'zones', 'cells', 'references', 'views', 'tile_slots', 'image', 'mask',
  'diagnosis', 'seen_depths', 'variances', 'sharp', 'fine', 'coarse', 'middles',
  'middle_colors', 'row_depths',
];
/** @param {string} name */
export const unitOf = (name) => SAMPLERS.indexOf(name);

/** @type {Record<string, {vertex?: string, fragment: string, defines?: string}>} */
const PASSES = {
  surface: {vertex: 'surface.vert', fragment: 'surface.frag'},
  silhouettes: {fragment: 'silhouettes.frag'},
  outline_rows: {fragment: 'outline_rows.frag'},
  outlines: {fragment: 'outlines.frag'},
  edges: {fragment: 'edges.frag'},
  edge_rows: {fragment: 'edge_rows.frag'},
  soft_edges: {fragment: 'soft_edges.frag'},
  blend: {fragment: 'blend.frag'},
  draft: {fragment: 'blend.frag', defines: '#define ONE_CELL\n#define LINEAR_SAMPLING\n'},
  samples: {fragment: 'blend.frag', defines: '#define SAMPLES\n'},
  diagnose: {fragment: 'diagnose.frag'},
  depth: {fragment: 'depth.frag'},
  photograph: {fragment: 'photograph.frag'},
  bc7: {fragment: 'bc7.frag'},
  etc2: {fragment: 'etc2.frag'},
  needs: {fragment: 'needs.frag'},
  gather: {fragment: 'surroundings.frag', defines: '#define GATHER\n'},
  halve: {fragment: 'surroundings.frag', defines: '#define HALVE\n'},
  fill: {fragment: 'surroundings.frag'},
  present: {fragment: 'page.frag'},
  modes: {fragment: 'modes.frag'},
  fade: {fragment: 'fade.frag'},
  glance: {fragment: 'glance.frag'},
};

/**
 * @typedef {{
 *   pass: string,
 *   program: WebGLProgram,
 *   shaders: WebGLShader[],
 *   linked: boolean,
 *   uniform: (name: string) => WebGLUniformLocation | null,
 * }} ProgramEntry
 */

// Compiled in the background where the browser can; a pass whose program is not ready() is not drawn yet.
export class Programs {
  // `views`: how many are blended at a pixel.
  /** @param {WebGL2RenderingContext} gl @param {Shaders} shaders @param {number} views */
  constructor(gl, shaders, views) {
    this.gl = gl;
    this.objects = new GlObjects(gl);
    this.shaders = shaders;
    this.views = views;
    this.parallel = gl.getExtension('KHR_parallel_shader_compile');
    this.clipControl = gl.getExtension('EXT_clip_control');
    /** @type {Map<string, ProgramEntry>} */
    this.programs = new Map();
  }

  /** @param {string} pass */
  entry(pass, cells = 0) {
    const key = `${pass} ${cells}`;
    const known = this.programs.get(key);
    if (known) return known;
    const started = this.started(pass, cells);
    this.programs.set(key, started);
    return started;
  }

  /** @param {string} pass @returns {boolean} */
  ready(pass, cells = 0) {
    const entry = this.entry(pass, cells);
    if (entry.linked || !this.parallel) return true;
    return this.gl.getProgramParameter(entry.program, this.parallel.COMPLETION_STATUS_KHR);
  }

  // Waits for it, if need be, and makes it current.
  /** @param {string} pass */
  use(pass, cells = 0) {
    const entry = this.entry(pass, cells);
    if (!entry.linked) this.finish(entry);
    this.gl.useProgram(entry.program);
    return entry;
  }

  /** @param {string} pass @param {number} cells @returns {ProgramEntry} */
  started(pass, cells) {
    const {gl} = this;
    const {definitions: ofAll, sources} = this.shaders;
    const {vertex = 'screen.vert', fragment, defines = ''} = PASSES[pass];
    const definitions = ofAll + `#define LATE_STENCIL\n#define BLENDED_VIEWS ${this.views}\n` +
        (this.clipControl ? '#define CLIP_CONTROL\n' : '') +
        (cells ? `#define CELLS ${cells}\n` : '') + defines;
    const program = this.objects.program();
    const withDefinitions = (/** @type {string} */ name) => sources[name].replace('\n', '\n' + definitions);
    const shaders = [
      this.objects.shader(program, gl.VERTEX_SHADER, withDefinitions(vertex)),
      this.objects.shader(program, gl.FRAGMENT_SHADER, withDefinitions(fragment)),
    ];
    gl.linkProgram(program);
    /** @type {Map<string, WebGLUniformLocation | null>} */
    const uniforms = new Map();
    const uniform = (/** @type {string} */ name) => {
      if (!uniforms.has(name)) uniforms.set(name, gl.getUniformLocation(program, name));
      return uniforms.get(name) ?? null;
    };
    return {pass, program, shaders, linked: false, uniform};
  }

  /** @param {ProgramEntry} entry */
  finish(entry) {
    const {gl} = this;
    const {program, shaders, pass} = entry;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      if (gl.isContextLost()) throw new ContextLost();
      const logs = shaders.map((shader) => gl.getShaderInfoLog(shader)).filter(Boolean);
      throw new Error(`the shader "${pass}" does not compile: ${[...logs, gl.getProgramInfoLog(program)].join(' ')}`);
    }
    const block = gl.getUniformBlockIndex(program, 'Picture');
    if (block !== gl.INVALID_INDEX) gl.uniformBlockBinding(program, block, 0);
    gl.useProgram(program);
    SAMPLERS.forEach((name, unit) => {
      const location = gl.getUniformLocation(program, name);
      if (location) gl.uniform1i(location, unit);
    });
    entry.linked = true;
  }

  release() {
    this.objects.release();
    this.programs.clear();
  }
}

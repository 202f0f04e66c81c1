// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest device that WebGL 2 allows: a browser whose contexts have the specification's least limits and no
// extension, and note each call that goes beyond them.
import assert from 'node:assert/strict';

// The least values that OpenGL ES 3.0 (section 6.2), and so WebGL 2, allows for each limit.
const LEAST = {
  MAX_TEXTURE_SIZE: 2048, MAX_3D_TEXTURE_SIZE: 256, MAX_ARRAY_TEXTURE_LAYERS: 256, MAX_RENDERBUFFER_SIZE: 2048,
  MAX_VERTEX_ATTRIBS: 16, MAX_VERTEX_UNIFORM_VECTORS: 256, MAX_FRAGMENT_UNIFORM_VECTORS: 224,
  MAX_TEXTURE_IMAGE_UNITS: 16, MAX_COMBINED_TEXTURE_IMAGE_UNITS: 32, MAX_VERTEX_TEXTURE_IMAGE_UNITS: 16,
  MAX_DRAW_BUFFERS: 4, MAX_COLOR_ATTACHMENTS: 4, MAX_SAMPLES: 4, MAX_UNIFORM_BLOCK_SIZE: 16384,
  MAX_VERTEX_UNIFORM_BLOCKS: 12, MAX_FRAGMENT_UNIFORM_BLOCKS: 12,
};

// Runs in each page before its scripts.
function limit(least) {
  const {prototype} = WebGL2RenderingContext;
  const GL = WebGL2RenderingContext;
  window.beyond = new Set();
  window.checkedPrograms = 0;
  const check = (what, value, most) => {
    if (value > most) window.beyond.add(`${what}: ${value} of ${most}`);
  };
  const before = (name, look) => {
    const own = prototype[name];
    prototype[name] = function(...values) {
      look.apply(this, values);
      return own.apply(this, values);
    };
  };
  const after = (name, look) => {
    const own = prototype[name];
    prototype[name] = function(...values) {
      const result = own.apply(this, values);
      look.call(this, values, result);
      return result;
    };
  };
  const limits = new Map(Object.entries(least).map(([name, value]) => [GL[name], value]));
  const ownParameter = prototype.getParameter;
  prototype.getParameter = function(name) {
    return limits.get(name) ?? ownParameter.call(this, name);
  };
  prototype.getExtension = () => null;
  prototype.getSupportedExtensions = () => [];

  const side = (what, width, height) => check(what, Math.max(width, height), least.MAX_TEXTURE_SIZE);
  before('texStorage2D', (target, levels, format, width, height) => side('texStorage2D', width, height));
  before('texStorage3D', (target, levels, format, width, height, depth) => {
    side('texStorage3D', width, height);
    check('layers', depth, least.MAX_ARRAY_TEXTURE_LAYERS);
  });
  before('texImage2D', (...values) => {
    if (values.length > 6) side('texImage2D', values[3], values[4]);
  });
  before('renderbufferStorage', (target, format, width, height) => side('renderbufferStorage', width, height));
  before('renderbufferStorageMultisample', (target, samples, format, width, height) => {
    side('renderbufferStorageMultisample', width, height);
    check('samples', samples, least.MAX_SAMPLES);
  });
  before('drawBuffers', (buffers) => check('draw buffers', buffers.length, least.MAX_DRAW_BUFFERS));
  before('activeTexture', (unit) => {
    check('texture units', unit - GL.TEXTURE0 + 1, least.MAX_COMBINED_TEXTURE_IMAGE_UNITS);
  });
  before('enableVertexAttribArray', (at) => check('vertex attributes', at + 1, least.MAX_VERTEX_ATTRIBS));
  before('viewport', (x, y, width, height) => side('viewport', width, height));

  // What a shader of the program may use of each: the whole program's, which is at least as much.
  const VECTORS = {[GL.FLOAT_MAT3]: 3, [GL.FLOAT_MAT4]: 4, [GL.FLOAT_MAT2]: 2};
  const SAMPLERS = [GL.SAMPLER_2D, GL.SAMPLER_3D, GL.SAMPLER_CUBE, GL.SAMPLER_2D_ARRAY, GL.SAMPLER_2D_SHADOW,
    GL.INT_SAMPLER_2D, GL.UNSIGNED_INT_SAMPLER_2D, GL.INT_SAMPLER_2D_ARRAY, GL.UNSIGNED_INT_SAMPLER_2D_ARRAY];
  const checked = new WeakSet();
  after('useProgram', function([program]) {
    if (!program || checked.has(program)) return;
    checked.add(program);
    ++window.checkedPrograms;
    let [vectors, samplers] = [0, 0];
    for (let i = 0; i < this.getProgramParameter(program, GL.ACTIVE_UNIFORMS); ++i) {
      const {type, size} = this.getActiveUniform(program, i);
      if (this.getActiveUniforms(program, [i], GL.UNIFORM_BLOCK_INDEX)[0] >= 0) continue;
      if (SAMPLERS.includes(type)) samplers += size;
      vectors += size * (VECTORS[type] ?? 1);
    }
    check('uniform vectors', vectors, least.MAX_FRAGMENT_UNIFORM_VECTORS);
    check('samplers', samplers, least.MAX_TEXTURE_IMAGE_UNITS);
    const blocks = this.getProgramParameter(program, GL.ACTIVE_UNIFORM_BLOCKS);
    check('uniform blocks', blocks, least.MAX_FRAGMENT_UNIFORM_BLOCKS);
    for (let i = 0; i < blocks; ++i) {
      const bytes = this.getActiveUniformBlockParameter(program, i, GL.UNIFORM_BLOCK_DATA_SIZE);
      check('bytes of a uniform block', bytes, least.MAX_UNIFORM_BLOCK_SIZE);
    }
  });
}

export const withLeastDevice = (page) => page.evaluateOnNewDocument(limit, LEAST);

// Returns the check that also makes sure that nothing went beyond the limits.
export const onLeastDevice = (check) => async (page, picture) => {
  await check(page, picture);
  const [beyond, programs] = await page.evaluate(() => [[...window.beyond], window.checkedPrograms]);
  assert.ok(programs > 3, `${programs} programs were looked at`);
  assert.deepEqual(beyond, []);
};

// SPDX-License-Identifier: GPL-3.0-or-later
// Lays the picture of a model into three's, with the depth of its surface, by a mesh that covers three's whole picture.
import {BufferAttribute, BufferGeometry, Matrix4, Mesh, ShaderMaterial, Texture, Vector4} from 'three';
/** @import {Camera, WebGLRenderer} from 'three' */
/** @import {PictureTarget} from '../page/drawing/gl_objects.js' */

const VERTEX = `
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;
// The surface's texels are those of blend/shaders/surface_texel.glsl.
const FRAGMENT = `
precision highp usampler2D;
uniform sampler2D colours;     // sRGB; alpha 0: no surface
uniform usampler2D surfaces;   // y: depth, in the object's own units
uniform vec4 viewport;
uniform float unit;            // of those depths, in the world
uniform float depth_before_far;
uniform bool shows_far;
uniform mat4 clip_from_view;
#if defined(USE_LOGARITHMIC_DEPTH_BUFFER) || defined(USE_LOGDEPTHBUF)
#define LOGARITHMIC
uniform float logDepthBufFC;
#endif

vec3 linear_of(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), vec3(greaterThan(c, vec3(0.04045))));
}

// Enlarged where the picture has fewer pixels.
vec3 colour_at(vec2 at, ivec2 size) {
  vec4 sum = vec4(0.0);
  vec2 first = floor(at - 0.5);
  vec2 f = at - 0.5 - first;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    vec2 share = mix(1.0 - f, f, vec2(corner));
    vec4 colour = texelFetch(colours, clamp(ivec2(first) + corner, ivec2(0), size - 1), 0);
    if (colour.a > 0.0) sum += share.x * share.y * vec4(colour.rgb, 1.0);
  }
  return sum.rgb / max(sum.a, 1e-6);
}

void main() {
  ivec2 size = textureSize(surfaces, 0);
  vec2 at = (gl_FragCoord.xy - viewport.xy) / viewport.zw * vec2(size);
  uvec4 texel = texelFetch(surfaces, clamp(ivec2(at), ivec2(0), size - 1), 0);
  if (texel.x == 0xFFFFFFFFu) discard;
  float z = uintBitsToFloat(texel.y);
  bool is_far = z >= depth_before_far;
  if (is_far && !shows_far) discard;
  vec4 clip = clip_from_view * vec4(0.0, 0.0, -unit * z, 1.0);
  float depth = 0.5 * clip.z / clip.w + 0.5;
  if (depth < 0.0 || (depth > 1.0 && !is_far)) discard;
#ifdef LOGARITHMIC
  depth = log2(1.0 + unit * z) * logDepthBufFC * 0.5;
#endif
  gl_FragDepth = is_far ? 1.0 : depth;
  gl_FragColor = vec4(linear_of(colour_at(at, size)), 1.0);
  #include <colorspace_fragment>
}`;

function screenTriangle() {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
  return geometry;
}

// The form in which three keeps a texture that is not its own.
/** @typedef {{__webglTexture: WebGLTexture, __webglInit: boolean}} TextureProperties */

export class ThreeLayer {
  // `draw(camera)` makes the picture that a camera is about to be shown, and calls show() or hide().
  /** @param {(camera: Camera) => void} draw */
  constructor(draw) {
    this.colours = new Texture();
    this.surfaces = new Texture();
    this.viewport = new Vector4();
    this.uniforms = {
      colours: {value: this.colours}, surfaces: {value: this.surfaces}, viewport: {value: this.viewport},
      unit: {value: 1}, depth_before_far: {value: 0}, shows_far: {value: true}, clip_from_view: {value: new Matrix4()},
    };
    this.material = new ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, toneMapped: false, uniforms: this.uniforms,
    });
    this.mesh = new Mesh(screenTriangle(), this.material);
    this.mesh.frustumCulled = false;
    this.mesh.raycast = () => {};  // a ray would hit it everywhere
    this.mesh.onBeforeRender = (_renderer, _scene, camera) => draw(camera);
  }

  // Returns where three draws in its target, pixels: x, y, width, height.
  /** @param {WebGLRenderer} renderer */
  viewportOf(renderer) {
    return renderer.getCurrentViewport(this.viewport);
  }

  hide() {
    this.mesh.geometry.setDrawRange(0, 0);
  }

  // `unit`: of the target's depths, in the world; `far`: whether what is at least `depthBeforeFar` deep is shown.
  /**
   * @param {WebGLRenderer} renderer
   * @param {PictureTarget} target
   * @param {{camera: Camera, unit: number, far: boolean, depthBeforeFar: number}} how
   */
  show(renderer, target, {camera, unit, far, depthBeforeFar}) {
    this.borrow(renderer, this.colours, target.colour);
    this.borrow(renderer, this.surfaces, target.surface);
    this.uniforms.unit.value = unit;
    this.uniforms.depth_before_far.value = depthBeforeFar;
    this.uniforms.shows_far.value = far;
    this.uniforms.clip_from_view.value = camera.projectionMatrix;
    this.material.uniformsNeedUpdate = true;
    this.mesh.geometry.setDrawRange(0, 3);
  }

  // Lets three bind a texture that it has not made.
  /** @param {WebGLRenderer} renderer @param {Texture} texture @param {WebGLTexture} made */
  borrow(renderer, texture, made) {
    const properties = /** @type {TextureProperties} */ (renderer.properties.get(texture));
    properties.__webglTexture = made;
    properties.__webglInit = true;
  }

  /** @param {WebGLRenderer} renderer */
  dispose(renderer) {
    for (const texture of [this.colours, this.surfaces]) renderer.properties.remove(texture);
    this.mesh.geometry.dispose();
    this.material.dispose();
  }
}

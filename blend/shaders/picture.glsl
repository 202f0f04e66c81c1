// The values of a picture that all its passes use. Every shader of a picture is GLSL ES 3.00, for OpenGL ES 3.0, WebGL
// 2 and desktop OpenGL alike. Mirrored by PictureBlock in renderer.cpp.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
precision highp usampler2D;
precision highp usampler2DArray;

layout(std140) uniform Picture {
  vec4 cam_from_world[3];  // rows: rotation, translation
  vec4 intrinsics;         // fx, fy, cx, cy in pixels
  vec4 clip_from_cam;      // scale x, scale y, shift x, shift y, of x / z and y / z
  vec4 center;             // the camera's in the world; height of the picture in pixels
  vec4 exposure;           // linear light of the model times this is shown; depth of the nearest surface drawn
  vec4 weights;            // lambda; 1 + occlusion tolerance; frame fade; depth before the far sphere
  ivec4 departures;        // 1 or 0: printed position, rims, fade last, consistent
  ivec4 sampling;          // levels with cubic sampling, levels; 1 or 0: prefilter, skip losers
  ivec4 tiles;             // width and height in pixels without the gutter, gutter, columns of slots in a page
  ivec4 samples;           // rows of slots in a page; samples across a pixel; 1 or 0: samples everywhere, soften
};

const uint kNothing = 0xFFFFFFFFu;  // no surface, no tile, no view

#version 450 core

in vec3 linear_color;
in vec4 cell_shares;

layout(location = 0) out uint face;
layout(location = 1) out float depth;   // z in the camera frame
layout(location = 2) out vec4 fallback;  // linear
layout(location = 3) out vec4 shares;    // of the zone's cells

void main() {
  face = uint(gl_PrimitiveID);
  depth = 1.0 / gl_FragCoord.w;
  fallback = vec4(linear_color, 1.0);
  shares = cell_shares;
}

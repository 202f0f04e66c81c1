// Tables of the model in textures, read by number: OpenGL ES 3.0 has no storage buffers.

uniform usampler2D zones;       // for each zone its references, from and to; the faces' cell; its deviation, see zone_mesh.h
uniform usampler2D cells;       // for each cell its references, from and to; 1 if an offered view saw it
// Slot of a view, and in the highest 4 bits which cells of the zone refer to it; an upper bound of its weight in the zone.
// Zones list the largest bound first, see blend/tables/ranked_references.h.
uniform usampler2D references;
#ifdef VIEWS_IN_BLOCK
layout(std140) uniform Views {  // as many as the block of every driver holds
  vec4 views[BLOCK_TEXELS];     // VIEW_TEXELS for each view slot
};
#else
uniform sampler2D views;  // the same
#endif
uniform usampler2D tile_slots;  // for each tile its place in the array

ivec2 place_of(uint number) {
  return ivec2(int(number) & (TABLE_WIDTH - 1), int(number) / TABLE_WIDTH);
}

uvec4 entry(usampler2D table, uint number) {
  return texelFetch(table, place_of(number), 0);
}

// A reference has the slot of a view, and a bit for each cell of the zone that refers to it.
uint slot_of(uint reference) {
  return reference & 0x0FFFFFFFu;
}

uint cells_of(uint reference) {
  return reference >> 28;
}

float bound_of(uvec2 reference) {
  return uintBitsToFloat(reference.y);
}

// Returns the deviation of the surface of a zone, scene units.
float deviation_of(uvec4 zone) {
  return uintBitsToFloat(zone.w << 16);
}

// Returns a texel of a stored view. 0 and 1: direction whose product with a point seen from its centre is fx x and fy
// y, with cx and cy; 2: the direction that it looks in, fx; 3: its centre in the world, the unit of its depths; 4:
// width and height in pixels, number of its first tile, tiles in a row; 5: gain of R G B.
vec4 view_texel(uint view, uint part) {
#ifdef VIEWS_IN_BLOCK
  return views[view * uint(VIEW_TEXELS) + part];
#else
  return texelFetch(views, place_of(view * uint(VIEW_TEXELS) + part), 0);
#endif
}

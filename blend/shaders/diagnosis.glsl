// What a pixel's colour is made of: the variant DIAGNOSE of blend.frag, as blend/diagnosis.h has it.

// How many views are valid, the best one's slot, and the shares of the three best in 16 bits each.
layout(location = 1) out uvec4 diagnosis;

const uint kNoView = 0xFFFFFFFFu;
const uvec4 kNoDiagnosis = uvec4(0u, kNoView, 0u, 0u);

// The weights of the three best in the picture, of all K + 1 that are ranked; they may sum to less than 1.
vec3 shares_of(float ranked[MAX_BLENDED_VIEWS + 1]) {
  float threshold = fade_last ? ranked[blended_views] : 0.0;
  vec3 shares = vec3(0.0);
  float total = 0.0;
  for (uint rank = 0u; rank < blended_views; ++rank) {
    float share = share_of(ranked[rank], threshold);
    total += share;
    if (rank < 3u) shares[rank] = share;
  }
  return total > 0.0 ? shares / total : vec3(ranked[0] > 0.0 ? 1.0 : 0.0, 0.0, 0.0);
}

// In the place of find_views(), which leaves out views that cannot win; here each is looked at. There is no colour then:
// Mesa's llvmpipe 22.3 loses pixels in the second of two loops whose neighbours end theirs at different counts.
bool diagnose(uint cell, vec3 world, float z) {
  float ranked[MAX_BLENDED_VIEWS + 1];
  for (uint rank = 0u; rank <= blended_views; ++rank) ranked[rank] = 0.0;
  vec3 to_novel = center - world;
  float o = length(to_novel);
  uint valid = 0u;
  uint winner = kNoView;
  for (uint reference = offsets[cell]; reference < offsets[cell + 1u]; ++reference) {
    uint slot = slots[reference];
    vec3 texel;
    float footprint;
    bool rim;
    if (!project(slot, world, z, texel, footprint, rim)) continue;
    vec3 to_stored = views[slot].center.xyz - world;
    float validity = sample_photograph(slot, texel, footprint).a;
    if (rim) validity *= rim_share(to_novel, o, to_stored);
    if (!(validity > 0.0)) continue;
    ++valid;
    float next = validity * geometric_weight(to_novel, o, to_stored);
    if (next > ranked[0]) winner = slot;
    for (uint rank = 0u; rank <= blended_views; ++rank) {
      float demoted = min(ranked[rank], next);
      ranked[rank] = max(ranked[rank], next);
      next = demoted;
    }
  }
  vec3 shares = shares_of(ranked);
  diagnosis = uvec4(valid, winner, packUnorm2x16(shares.xy), packUnorm2x16(vec2(shares.z, 0.0)));
  return winner != kNoView;
}

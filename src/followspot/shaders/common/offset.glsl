// How a receiver is moved before it is looked up in a shadow map, so that it does not shadow itself.
//
// It is moved off its surface by a part of a texel (Holbert, "Saying goodbye to shadow acne", 2011),
// but only across the map, as its normal points: moved towards the light as well, the foot of a
// shaded wall would come to lie in the wall, where light is.

// What is in the map with its lit side is moved by LIT_SIDE times the normal offset: across the map
// where the cosine of light and normal is below GRAZING, in depth where it is above STEEP.

// By how much it is moved nearer to the light; in normal offsets, as `across`, which may change.
float moved_nearer(float cosine, inout vec2 across) {
#if defined(SHOWS_BACKS) || defined(LIT_SIDES_CAST)
    // It is in the map itself and would shadow itself. It is moved towards the light by the depth
    // that a plane of its slope gains from texel to texel, which leaves shadows' edges on it in
    // place, and by one offset at least, for rounding. Under grazing light that depth has no bound:
    // there it is moved across instead.
    float facing = smoothstep(GRAZING, STEEP, cosine);
    float deepens = (abs(across.x) + abs(across.y)) / max(cosine, GRAZING);
    across *= mix(LIT_SIDE, 1.0, facing);
    return LIT_SIDE * mix(max(cosine, 0.0), max(deepens, cosine / LIT_SIDE), facing);
#else
    return 0.0;
#endif
}

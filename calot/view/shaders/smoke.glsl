// Smoke, steam and haze. For frame.glsl and noise.glsl; colours are linear.

// Share of what lies behind that a puff hides. `at` -1 ... 1 over its disc, which is its radius wide; depth, turn and seed
// as PuffState has them. Lumps and wisps, not a ball: the density is torn by two scales of noise.
float smoke_opacity(vec2 at, float depth, float turn, float seed) {
  float r2 = dot(at, at);
  if (r2 >= 1.0) return 0.0;
  float c = cos(turn), s = sin(turn);
  vec3 p = vec3(c * at.x - s * at.y, s * at.x + c * at.y, 19.0 * seed);
  float lumps = patches_at(2.6 * p + 7.0 * seed);
  float wisps = patches_at(6.1 * p.yxz + 3.0 * lumps);
  float density = exp(-2.0 * r2) * smoothstep(1.0, 0.55, r2) * (0.35 + 1.3 * lumps * (0.45 + wisps));
  return 1.0 - exp(-depth * density);
}

// Where soft discs meet tissue they fade: `gap` [m] between the tissue and the puff along the view, its radius [m].
float smoke_softness(float gap, float radius) {
  return clamp(gap / max(0.6 * radius, 1e-4), 0.0, 1.0);
}

// What smoke (0) or steam (1) throws back of the lamp at a place. Small particles: bluish-grey, brighter towards the lamp.
vec3 smoke_light(vec3 position, float steam) {
  vec3 to_light = light.xyz - position;
  float lamp = light.w / max(dot(to_light, to_light), 1e-4);
  return mix(vec3(0.36, 0.38, 0.41), vec3(0.62), steam) * (0.5 * lamp + ambient.rgb);
}

// A colour seen through `distance` [m] of haze of this extinction [1/m]: dimmed, and veiled by the lit gas before it.
vec3 through_haze(vec3 color, float haze, float distance) {
  float left = exp(-haze * distance);
  return mix(vec3(0.20, 0.205, 0.215) * (1.0 + ambient.rgb), color, left);
}

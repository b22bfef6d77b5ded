// Liquid in pools and drops, and sparks. For frame.glsl, material.glsl and light.glsl; colours are linear.

// How much of what lies behind a liquid is hidden: Beer-Lambert; blood hides within tenths of a millimetre. thickness [m]
float liquid_opacity(float thickness, float bile) {
  return 1.0 - exp(-thickness / mix(0.15e-3, 1.6e-3, bile));
}

// Blood or bile `thickness` [m] deep, clotted 0 ... 1. Give shade() its material, and blend by liquid_opacity().
Material liquid(float thickness, float bile, float clot) {
  float deep = 1.0 - exp(-thickness / 0.7e-3);
  vec3 blood = mix(vec3(0.130, 0.008, 0.006), vec3(0.082, 0.0042, 0.0038), deep);
  blood = mix(blood, vec3(0.030, 0.0045, 0.004), 0.8 * clot);
  vec3 gall = mix(vec3(0.26, 0.20, 0.015), vec3(0.115, 0.090, 0.006), deep);
  Material m;
  m.base = mix(blood, gall, bile);
  m.roughness = 0.35;
  m.coat = 1.0 - 0.55 * clot * (1.0 - bile);
  m.coat_roughness = mix(0.07, 0.32, clot * (1.0 - bile));
  m.subsurface = mix(vec3(0.10, 0.01, 0.01), vec3(0.18, 0.15, 0.03), bile);
  m.height = 0.0;
  m.metal = 0.0;
  m.ao = 1.0;
  return m;
}

// A drop as a disc turned to the eye: `at` -1 ... 1 over it, `across` and `along` the disc's unit axes in the world.
// The normal there; its length is 0 outside of the drop.
vec3 drop_normal(vec2 at, vec3 across, vec3 along, vec3 to_eye) {
  float r2 = dot(at, at);
  if (r2 > 1.0) return vec3(0.0);
  return normalize(at.x * across + at.y * along + sqrt(1.0 - r2) * to_eye);
}

// A spark's own light on its streak: `at`.x -1 ... 1 across, .y 0 (its end) ... 1 (its head); heat 1 ... 0. Additive.
vec3 spark_light(vec2 at, float heat) {
  vec3 color = mix(vec3(1.0, 0.16, 0.02), vec3(1.0, 0.78, 0.42), smoothstep(0.15, 0.8, heat));
  float core = exp(-5.0 * at.x * at.x) * at.y * at.y;
  return color * (core * heat * 14.0);
}

// What tissue looks like at a point of its rest shape, so that motion and cuts leave it alone. Textures come from
// calot/view/textures.h, recipes from looks.glsl.
#include "material.glsl"
#include "noise.glsl"
#include "looks.glsl"

uniform sampler3D tissue_noise;   // lobules, pillows, clouds, strands
uniform sampler2D tissue_detail;  // vessels: wide, fine, the flush around them; grain

const float mm = 1e-3;
const float detail_tile = 27.0 * mm;

// sRGB to linear light: a cubic that is right within 0.003.
vec3 linear_light(vec3 c) { return c * (c * (c * 0.3053 + 0.6822) + 0.0125); }

// A bruise shines blue through the surface; where no blood flows it is pale.
void bruise_and_blanch(inout Material m, float bruised, float blanched, vec4 s, float large) {
  bruised *= smoothstep(0.25, 0.75, 0.6 * large + 0.5 * s.b);
  m.base = mix(m.base, vec3(0.085, 0.035, 0.09) + 0.25 * m.base, 0.8 * bruised);
  float light = dot(m.base, vec3(0.3, 0.6, 0.1));
  m.base = mix(m.base, mix(vec3(light), vec3(0.62, 0.50, 0.40), 0.55), 0.6 * blanched);
}

// Boiled tissue: grey-tan, dull, a little shrunken.
void coagulate(inout Material m, float coagulated, vec4 s) {
  float cooked = ragged(coagulated, s.b, 0.15, 0.75);
  float light = dot(m.base, vec3(0.3, 0.6, 0.1));
  vec3 tan_grey = mix(vec3(0.25, 0.175, 0.115), vec3(0.50, 0.42, 0.32), smoothstep(0.2, 0.85, s.b));
  tan_grey *= 0.7 + 0.5 * sqrt(light);
  m.base = mix(m.base, tan_grey, 0.85 * cooked);
  m.subsurface *= 1.0 - 0.6 * cooked;
  m.roughness = mix(m.roughness, 0.72, cooked);
  m.coat *= 1.0 - 0.75 * cooked;
  m.coat_roughness = mix(m.coat_roughness, 0.4, cooked);
  m.height += cooked * mm * (0.04 * s.r + 0.05 * s.a + 0.16 * s.b - 0.15);
}

// A dull brown-black crust, crumbly and finely cracked; never quite black.
void char_over(inout Material m, float charred, vec4 s) {
  charred = ragged(charred, s.b, 0.2, 0.7);
  float crack = smoothstep(0.35, 0.95, s.a);
  vec3 crust = mix(vec3(0.015, 0.010, 0.0075), vec3(0.060, 0.036, 0.022), smoothstep(0.35, 0.8, s.b + 0.12 * s.r));
  m.base = mix(m.base, mix(crust, vec3(0.055, 0.022, 0.012), 0.6 * crack), charred);
  m.subsurface *= 1.0 - charred;
  m.roughness = mix(m.roughness, 0.92, charred);
  m.coat *= 1.0 - charred;
  m.height += charred * mm * (0.05 * s.r + 0.38 * s.b - 0.14 * crack);
}

// Blood or bile: lets the tissue through where thin, stands over it where thick, and shines.
// `through`: what a thin film lets through; `shallow`, `deep`: its own colour, thin and thick.
void film_over(inout Material m, float mask, float noise, vec3 through, vec3 shallow, vec3 deep) {
  float film = ragged(mask, noise, 0.16, 0.46);
  float thick = film * smoothstep(0.25, 1.05, mask + 0.35 * (noise - 0.5));
  vec3 clear = mix(vec3(1.0), through * (1.0 - thick), film);
  m.base = m.base * clear + mix(shallow, deep, thick) * (1.0 - clear);
  m.subsurface *= 1.0 - 0.7 * film;
  m.roughness = mix(m.roughness, 0.35, film);
  m.coat = mix(m.coat, 1.0, film);
  m.coat_roughness = mix(m.coat_roughness, 0.10, film);
  m.height = mix(m.height, 0.3 * m.height, thick) + mm * (0.05 * film + 0.20 * thick);
  m.ao = mix(m.ao, 1.0, film);
}

// look, cut: constants. rest [m], rest_normal unit, in the rest shape. condition: coagulated, charred, blanched, bruised;
// mask: blood, char, bile, wet; each 0 ... 1. lite: a constant; one plane of vessels instead of three.
Material tissue(int look, bool cut, vec3 rest, vec3 rest_normal, vec4 condition, vec4 mask, bool lite) {
  Recipe r;
  if (cut) r = cut_recipe(look); else r = outside_recipe(look);

  vec3 turned = turned_lattice * rest;
  vec4 s = texture(tissue_noise, turned * r.stretch / (r.tile * mm));
  float large = patches_at(turned * (6.2832 / (r.large * mm)));
  vec4 v = vec4(0.0, 0.0, 0.0, 0.5);
  if (r.vessels.x > 0.0 || (r.grain > 0.0 && !lite)) {
    v = laid_on(tissue_detail, rest / detail_tile, rest_normal, !lite);
  }

  float pattern = clamp(dot(r.pattern, s - 0.5) + r.bias, 0.0, 1.0);
  vec3 color = mix(r.low, r.high, pattern);
  color = mix(color, r.patch_color, r.patches * smoothstep(0.15, 0.85, large));
  float tube = smoothstep(0.82, 0.94, s.g) * smoothstep(0.40, 0.55, s.b);
  float marks = dot(r.vessels, v.rgb) + r.ducts * tube + r.strands * s.a * smoothstep(0.25, 0.65, s.b);
  color = mix(color, r.mark, min(marks, 0.9));
  color *= 1.0 - 0.75 * r.ducts * tube * smoothstep(0.92, 0.99, s.g);  // what flows in the tube is dark

  Material m;
  m.base = linear_light(color);
  m.roughness = r.roughness;
  m.coat = r.coat;
  m.coat_roughness = r.coat_roughness;
  m.subsurface = r.subsurface;
  m.height = mm * (dot(r.relief, s) + r.grain * (lite ? 0.5 : v.a));
  m.metal = 0.0;
  m.ao = 1.0;

  bruise_and_blanch(m, condition.w, condition.z, s, large);
  coagulate(m, condition.x, s);
  char_over(m, max(condition.y, mask.y), s);
  film_over(m, mask.z, s.b, vec3(0.72, 0.62, 0.12), vec3(0.20, 0.15, 0.010), vec3(0.115, 0.090, 0.006));
  film_over(m, mask.x, s.b, vec3(0.50, 0.06, 0.05), vec3(0.105, 0.006, 0.005), vec3(0.065, 0.0034, 0.0034));
  m.coat = mix(m.coat, 1.0, 0.8 * mask.w);
  m.coat_roughness = mix(m.coat_roughness, 0.12, 0.7 * mask.w);
  return m;
}

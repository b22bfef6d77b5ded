// Instruments: brushed and polished steel, black insulation, ceramic, titanium. Colours are linear. There is no picture
// of the surroundings to mirror, so metal mirrors a made-up abdomen: `cavity_reflection`.

const int brushed_steel = 0, polished_steel = 1, insulation = 2, ceramic = 3, titanium = 4;  // ModelMaterial

struct Metal {
  vec3 base;     // what metal mirrors, and of plastic and ceramic the diffuse colour
  vec3 f0;       // mirrored straight on
  float along;   // roughness (alpha) along the fine lines and across them
  float across;
  float diffuse;
};

float metal_hash(vec2 p) {
  vec3 q = fract(vec3(p.xyx) * vec3(0.1031, 0.1030, 0.0973));
  q += dot(q, q.yzx + 33.33);
  return fract((q.x + q.y) * q.z);
}

float metal_noise(vec2 p) {
  vec2 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  vec2 s = vec2(0.0, 1.0);
  return mix(mix(metal_hash(i), metal_hash(i + s.yx), f.x), mix(metal_hash(i + s.xy), metal_hash(i + s.yy), f.x), f.y);
}

// Where a point is across the lines and along them [m]. `grain` is in the instrument's own frame: the lines of turned
// parts run round z, those of jaws along it.
vec2 on_lines(vec3 place, vec3 grain) {
  vec3 side = abs(grain.z) > 0.7 ? vec3(0.62, 0.78, 0.0) : vec3(0.0, 0.0, 1.0);
  return vec2(dot(place, side), abs(grain.z) > 0.7 ? place.z : atan(place.y, place.x) * 0.002);
}

// Noise of lines `width` [m] apart; fades to its mean where a pixel covers several of them.
float lines(vec2 at, float width, float length, float pixel) {
  float visible = 1.0 - smoothstep(0.35, 1.2, pixel / width);
  return visible * (metal_noise(at / vec2(width, length)) - 0.5);
}

Metal metal_of(int substance, vec2 at, float pixel) {
  float fine = lines(at, 0.00006, 0.004, pixel) + 0.6 * lines(at + 0.37, 0.00022, 0.009, pixel);
  float worn = metal_noise(at * vec2(700.0, 260.0)) - 0.5;
  Metal m;
  m.diffuse = 0.0;
  m.base = vec3(0.0);
  if (substance == insulation) {
    m.base = vec3(0.006, 0.006, 0.007);
    m.f0 = vec3(0.04);
    m.along = m.across = 0.22 + 0.08 * worn;
    m.diffuse = 1.0;
  } else if (substance == ceramic) {
    m.base = vec3(0.66, 0.62, 0.54) * (1.0 + 0.06 * worn);
    m.f0 = vec3(0.05);
    m.along = m.across = 0.16;
    m.diffuse = 1.0;
  } else if (substance == titanium) {
    m.f0 = vec3(0.52, 0.50, 0.475) * (1.0 + 0.10 * fine);
    m.along = 0.20;
    m.across = 0.30;
    m.base = 0.16 * m.f0;
    m.diffuse = 1.0;
  } else if (substance == polished_steel) {
    m.f0 = vec3(0.60, 0.585, 0.57) * (1.0 + 0.05 * fine + 0.05 * worn);
    m.along = 0.085;
    m.across = 0.16 + 0.05 * worn;
    m.base = 0.12 * m.f0;  // light that scratches throw about, like a very rough lobe
    m.diffuse = 1.0;
  } else {
    m.f0 = vec3(0.56, 0.55, 0.54) * (1.0 + 0.16 * fine + 0.07 * worn);
    m.along = 0.12;
    m.across = 0.34 + 0.06 * worn;
    m.base = 0.20 * m.f0;
    m.diffuse = 1.0;
  }
  return m;
}

// What a mirror sees along `ray`, blurred by `rough` (0 ... 1): lit tissue ahead, paler fat in places, the dark wall of
// the belly behind, the scope's lit end around the lamp. In units of the light that comes from everywhere.
vec3 cavity_reflection(vec3 ray, float rough) {
  float ahead = dot(ray, forward.xyz), high = dot(ray, up.xyz), aside = dot(ray, right.xyz);
  float blur = 0.12 + rough;
  vec3 wall = vec3(0.30, 0.16, 0.13), lit = vec3(1.0, 0.62, 0.52), fat = vec3(1.0, 0.84, 0.62);
  float lit_share = smoothstep(-0.25 - blur, 0.55 + blur, ahead);
  float lumps = metal_noise(vec2(aside, high) * 3.1 + 11.0 + 2.0 * ahead) - 0.5;
  vec3 seen = mix(0.45 * wall, 3.2 * mix(lit, fat, smoothstep(0.05, 0.35, lumps + 0.3 * high)), lit_share);
  seen *= 1.0 + 1.1 * lumps * (1.0 - 0.7 * clamp(rough * 2.0, 0.0, 1.0));
  seen *= 1.0 - 0.55 * smoothstep(-0.2, 0.9, -high) * (1.0 - 0.5 * lit_share);  // less from below the scope
  float glow = exp2(-9.0 * (1.0 + ahead) / (0.25 + rough));
  return seen * dot(ambient.rgb, vec3(0.34)) + ambient.rgb * 5.0 * glow;
}

// Anisotropic GGX [Burley2012]; Smith's term approximated with the mean roughness [Hammon2017].
float brushed_specular(Metal m, vec3 n, vec3 t, vec3 h, float n_l, float n_v) {
  vec3 b = cross(n, t);
  float x = dot(h, t) / m.along, y = dot(h, b) / m.across, z = dot(h, n);
  float d = x * x + y * y + z * z;
  float mean = sqrt(m.along * m.across);
  float visible = 0.5 / max(mix(2.0 * n_l * n_v, n_l + n_v, mean), 1e-4);
  return visible / (3.14159265 * m.along * m.across * d * d);
}

// The light that an instrument sends to the eye. `grain`: unit, in the world's frame, and as it is in the instrument's
// own frame, where `place` is as well. Needs frame.glsl and light.glsl.
vec3 metal_light(int substance, vec3 n, vec3 position, vec3 grain, vec3 place, vec3 own_grain, float open) {
  vec3 to_eye = eye.xyz - position, to_light = light.xyz - position;
  float d2 = dot(to_light, to_light), pixel = length(fwidth(place));
  vec3 v = normalize(to_eye), l = to_light * inversesqrt(d2), h = normalize(l + v);
  vec2 at = on_lines(place, own_grain);
  Metal m = metal_of(substance, at, pixel);
  vec3 t = normalize(grain - dot(grain, n) * n);
  float n_l = max(dot(n, l), 0.0), n_v = max(dot(n, v), 0.04);
  float widening = 0.004 * inversesqrt(d2);  // the lamp's end is about 3 mm wide [Karis2013]
  m.along = clamp(m.along + widening, 0.02, 1.0);
  m.across = clamp(m.across + widening, 0.02, 1.0);
  float lamp = light.w / d2 * lamp_cone(dot(-l, light_axis.xyz)) * lamp_visibility(position, n, sqrt(d2));
  float fresnel = schlick(max(dot(v, h), 0.0));
  vec3 f = m.f0 + (1.0 - m.f0) * fresnel;
  vec3 color = (m.diffuse * m.base * (1.0 - f) + 3.14159265 * f * brushed_specular(m, n, t, h, n_l, n_v)) * lamp * n_l;

  // The mirrored direction of lines is spread across them: the normal is bent towards the eye in that plane.
  vec3 b = cross(n, t);
  vec3 bent = normalize(mix(n, normalize(cross(t, cross(v, t)) + 1e-4 * n), clamp(m.across - m.along, 0.0, 0.6)));
  float rough = sqrt(m.along * m.across);
  vec3 mirrored = cavity_reflection(reflect(-v, bent), rough) * (0.25 + 0.75 * open);
  float grazing = schlick(n_v) * (substance == insulation ? 0.3 : 1.0);  // its grain shadows itself
  vec3 share = m.f0 + (max(vec3(1.0 - rough), m.f0) - m.f0) * grazing;
  color += mirrored * share * open + m.diffuse * m.base * ambient.rgb * open;
  return color;
}

// Helpers of tissue.glsl: how textures are laid on a body, and edges that don't look airbrushed.

// Turned against the axes by angles that no lattice has: flat slices of the periodic volume then never repeat.
const mat3 turned_lattice = mat3(0.7071, 0.5417, -0.4545, -0.6428, 0.7660, -0.0870, 0.2947, 0.3463, 0.8906);

// Large soft patches, 0 ... 1: bent waves cost less than reading a texture again.
float patches_at(vec3 p) {
  return 0.5 + 0.5 * sin(p.x + 1.3 * sin(p.y)) * sin(1.4 * p.z + 1.2 * sin(1.7 * p.x + 0.6 * p.y));
}

// The part of a place that lies in the plane across axis 0, 1 or 2; a place of its own on the tile for each.
vec2 on_plane(vec3 at, int axis) { return axis == 0 ? at.yz : axis == 1 ? at.zx + 0.37 : at.xy + 0.71; }

// A tile laid on a body along the nearest plane, or the two nearest blended: their weights fade before a third one would be
// nearer. The level comes from `at`, which doesn't jump where planes change.
vec4 laid_on(sampler2D tile, vec3 at, vec3 normal, bool blend) {
  vec3 n = abs(normal);
  vec3 a = dFdx(at), b = dFdy(at);
  float texels = float(textureSize(tile, 0).x);
  float level = 0.5 * log2(max(max(dot(a, a), dot(b, b)) * texels * texels, 1.0));
  int first = n.x > n.y ? (n.x > n.z ? 0 : 2) : (n.y > n.z ? 1 : 2);
  vec4 nearest = textureLod(tile, on_plane(at, first), level);
  if (!blend) return nearest;
  int last = n.x < n.y ? (n.x < n.z ? 0 : 2) : (n.y < n.z ? 1 : 2);
  float largest = max(n.x, max(n.y, n.z)), smallest = min(n.x, min(n.y, n.z)), middle = n.x + n.y + n.z - largest - smallest;
  vec4 second = textureLod(tile, on_plane(at, 3 - first - last), level);
  float one = largest - smallest, two = middle - smallest;
  return (one * one * one * nearest + two * two * two * second) / (one * one * one + two * two * two + 1e-4);
}

// How much of a painted mask shows: its soft edge broken up by noise (0 ... 1); none where the mask is 0, all where 1.
float ragged(float mask, float noise, float low, float high) {
  float band = 4.0 * mask * (1.0 - mask);
  return smoothstep(low, high, mask + (noise - 0.5) * band * 0.9);
}

#include "calot/view/textures.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "calot/base/parallel.h"

namespace calot {
namespace {

constexpr int volume_size = 128, small_volume_size = 64;  // the small one fits a processor's cache
constexpr int vessel_size = 512;

// Only + - * / and square roots below: every machine rounds those alike.

/// Well mixed bits of a lattice point; after the mixing steps of [Jarzynski2020]'s pcg3d.
std::array<std::uint32_t, 3> mixed(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const auto step = [](std::uint32_t v) { return v * 1664525U + 1013904223U; };
  x = step(x), y = step(y), z = step(z);
  for (int round = 0; round < 2; ++round) {
    x += y * z, y += z * x, z += x * y;
    if (round == 0) x ^= x >> 16U, y ^= y >> 16U, z ^= z >> 16U;
  }
  return {x, y, z};
}

double unit(std::uint32_t bits) {
  return (bits >> 8U) * (1.0 / 16777216.0);
}

/// A stream of numbers in [0, 1).
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : seed_(seed) {}
  double operator()() { return unit(mixed(seed_, count_++, 77U)[0]); }

 private:
  std::uint32_t seed_, count_ = 0;
};

/// i within a lattice, for an i that is at most one period outside.
int wrapped(int i, int period) {
  return i < 0 ? i + period : i >= period ? i - period : i;
}

/// i within a lattice, from anywhere.
int wrapped_far(int i, int period) {
  return wrapped(i % period, period);
}

struct Point {
  double x = 0, y = 0, z = 0;
};

/// The cell of a coordinate and how far into it.
struct Split {
  int cell;
  double into;
};

/// The integer below; std::floor is a call where the processor isn't known to have it.
int below(double v) {
  const int i = static_cast<int>(v);
  return v < i ? i - 1 : i;
}

Split split(double v) {
  const int whole = below(v);
  return {whole, v - whole};
}

/// Gradient noise of period 1 with `cells` along it, about -1 … 1 [Perlin2002].
class GradientNoise {
 public:
  GradientNoise(int cells, std::uint32_t seed) : cells_(cells) {
    static constexpr std::array<std::array<double, 3>, 12> edges{{{1, 1, 0},
                                                                  {-1, 1, 0},
                                                                  {1, -1, 0},
                                                                  {-1, -1, 0},
                                                                  {1, 0, 1},
                                                                  {-1, 0, 1},
                                                                  {1, 0, -1},
                                                                  {-1, 0, -1},
                                                                  {0, 1, 1},
                                                                  {0, -1, 1},
                                                                  {0, 1, -1},
                                                                  {0, -1, -1}}};
    const auto n = static_cast<std::uint32_t>(cells);
    for (std::uint32_t k = 0; k < n * n * n; ++k)
      slopes_.push_back(edges[mixed(k % n + seed * 131U, k / n % n, k / (n * n))[0] % 12U]);
  }

  /// The noise along x for one y and z: much less work for many x.
  class Row {
   public:
    Row(const GradientNoise& noise, double py, double pz) : cells_(noise.cells_) {
      const Split y = split(py * cells_), z = split(pz * cells_);
      const double v = fade(y.into), w = fade(z.into);
      for (int i = 0; i < cells_; ++i) {
        Column column;
        for (int k = 0; k < 4; ++k) {
          const int j = k & 1, l = k >> 1;
          const auto& slope = noise.slope(i, wrapped(y.cell + j, cells_), wrapped(z.cell + l, cells_));
          const double weight = (j != 0 ? v : 1 - v) * (l != 0 ? w : 1 - w);
          column.value += weight * (slope[1] * (y.into - j) + slope[2] * (z.into - l));
          column.rise += weight * slope[0];
        }
        columns_.push_back(column);
      }
    }
    double operator()(double px) const {
      const Split x = split(px * cells_);
      const Column& a = columns_[static_cast<std::size_t>(wrapped(x.cell, cells_))];
      const Column& b = columns_[static_cast<std::size_t>(wrapped(x.cell + 1, cells_))];
      const double left = a.value + a.rise * x.into, right = b.value + b.rise * (x.into - 1);
      return left + fade(x.into) * (right - left);
    }

   private:
    struct Column {
      double value = 0, rise = 0;
    };
    int cells_;
    std::vector<Column> columns_;
  };

  double operator()(const Point& p) const {
    const Split x = split(p.x * cells_), y = split(p.y * cells_), z = split(p.z * cells_);
    const int xs[2] = {wrapped(x.cell, cells_), wrapped(x.cell + 1, cells_)};
    const int ys[2] = {wrapped(y.cell, cells_), wrapped(y.cell + 1, cells_)};
    const int zs[2] = {wrapped(z.cell, cells_), wrapped(z.cell + 1, cells_)};
    double corner[8];
    for (int k = 0; k < 8; ++k) {
      const int i = k & 1, j = (k >> 1) & 1, l = k >> 2;
      const auto& slope = this->slope(xs[i], ys[j], zs[l]);
      corner[k] = slope[0] * (x.into - i) + slope[1] * (y.into - j) + slope[2] * (z.into - l);
    }
    const double u = fade(x.into), v = fade(y.into), w = fade(z.into);
    const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
    return mix(mix(mix(corner[0], corner[1], u), mix(corner[2], corner[3], u), v),
               mix(mix(corner[4], corner[5], u), mix(corner[6], corner[7], u), v), w);
  }

 private:
  const std::array<double, 3>& slope(int i, int j, int k) const {
    return slopes_[static_cast<std::size_t>((k * cells_ + j) * cells_ + i)];
  }
  static double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
  int cells_;
  std::vector<std::array<double, 3>> slopes_;
};

/// Octaves of noise, each twice as fine and half as strong.
class Clouds {
 public:
  Clouds(int cells, int octaves, std::uint32_t seed) {
    for (int k = 0; k < octaves; ++k) octaves_.emplace_back(cells << k, seed + static_cast<std::uint32_t>(k));
  }
  /// Along x for one y and z.
  class Row {
   public:
    Row(const Clouds& clouds, double y, double z) {
      for (const GradientNoise& octave : clouds.octaves_) octaves_.emplace_back(octave, y, z);
    }
    double operator()(double x) const {
      double sum = 0, amplitude = 1;
      for (const GradientNoise::Row& octave : octaves_) sum += amplitude * octave(x), amplitude *= 0.5;
      return sum;
    }

   private:
    std::vector<GradientNoise::Row> octaves_;
  };

 private:
  std::vector<GradientNoise> octaves_;
};

/// Rounded cells around jittered points, smooth everywhere: compact weights (1 - d²/R²)^8 of the points around.
class Cells {
 public:
  struct Value {
    double inside = 0;  ///< how much one point outweighs the others: 1 inside, ½ between two, less where more meet
    double dome = 0;    ///< 1 at a point, falling with the distance squared
  };

  Cells(int cells, std::uint32_t seed) : cells_(cells) {
    for (int k = 0; k < cells; ++k)
      for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) around_.push_back(points_around(i, j, k, seed));
  }

  Value operator()(const Point& p) const {
    constexpr float nearness = 1 / (1.2F * 1.2F);
    const Split x = split(p.x * cells_), y = split(p.y * cells_), z = split(p.z * cells_);
    const Around& around = around_[static_cast<std::size_t>(
        (wrapped(z.cell, cells_) * cells_ + wrapped(y.cell, cells_)) * cells_ + wrapped(x.cell, cells_))];
    const auto px = static_cast<float>(x.into), py = static_cast<float>(y.into), pz = static_cast<float>(z.into);
    // Four sums side by side, so that the compiler can use wide registers and the order is still fixed.
    std::array<float, 4> sum{}, squares{};
    for (std::size_t block = 0; block < 28; block += 4)
      for (std::size_t k = 0; k < 4; ++k) {
        const float dx = around.x[block + k] - px, dy = around.y[block + k] - py, dz = around.z[block + k] - pz;
        float w = 1 - (dx * dx + dy * dy + dz * dz) * nearness;
        w = w > 0 ? w : 0;
        w *= w, w *= w, w *= w;
        sum[k] += w;
        squares[k] += w * w;
      }
    const double all = double{sum[0]} + sum[1] + sum[2] + sum[3];
    if (all < 1e-12) return {};
    return {(double{squares[0]} + squares[1] + squares[2] + squares[3]) / (all * all),
            std::sqrt(std::sqrt(std::sqrt(all)))};
  }

 private:
  /// The points of a cell and its 26 neighbours, seen from its corner; the last place is far away.
  struct Around {
    std::array<float, 28> x, y, z;
  };

  Around points_around(int i, int j, int k, std::uint32_t seed) const {
    Around around{};
    around.x[27] = 9;
    const auto place = [&](int at, int by) { return static_cast<std::uint32_t>(wrapped(at + by, cells_)); };
    for (std::size_t n = 0; n < 27; ++n) {
      const int a = static_cast<int>(n % 3) - 1, b = static_cast<int>(n / 3 % 3) - 1, c = static_cast<int>(n / 9) - 1;
      const auto bits = mixed(place(i, a) + seed * 977U, place(j, b), place(k, c));
      around.x[n] = static_cast<float>(a + 0.15 + 0.7 * unit(bits[0]));
      around.y[n] = static_cast<float>(b + 0.15 + 0.7 * unit(bits[1]));
      around.z[n] = static_cast<float>(c + 0.15 + 0.7 * unit(bits[2]));
    }
    return around;
  }

  int cells_;
  std::vector<Around> around_;
};

std::uint8_t byte_of(double v) {
  return static_cast<std::uint8_t>(std::clamp(v, 0.0, 1.0) * 255.0 + 0.5);
}

double smooth_step(double low, double high, double v) {
  const double t = std::clamp((v - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// A film where the noise is zero, as wide as `width`.
double film(double noise, double width) {
  const double t = noise / width;
  return 1 / (1 + t * t);
}

/// The fields of the solid noise.
struct VolumeFields {
  GradientNoise bend_x{5, 11}, bend_y{5, 12}, bend_z{5, 13};
  Cells small{9, 1}, large{4, 2};
  Clouds cloud{4, 4, 21};
  GradientNoise films[3] = {{3, 31}, {5, 32}, {9, 33}};

  /// `n` texels along x for one y and z.
  void row(double y, double z, int n, std::uint8_t* out) const {
    const GradientNoise::Row bent_x(bend_x, y, z), bent_y(bend_y, y, z), bent_z(bend_z, y, z);
    const Clouds::Row clouded(cloud, y, z);
    for (int i = 0; i < n; ++i, out += 4) {
      const double x = (i + 0.5) / n;
      const Point bend{bent_x(x), bent_y(x), bent_z(x)};
      const auto bent = [&](double by) { return Point{x + by * bend.x, y + by * bend.y, z + by * bend.z}; };
      const Cells::Value lobule = small(bent(0.035)), pillow = large(bent(0.035));
      out[0] = byte_of(smooth_step(0.30, 0.95, lobule.inside));
      out[1] = byte_of((pillow.dome - 0.55) / 0.45 * (0.35 + 0.65 * smooth_step(0.25, 0.85, pillow.inside)));
      out[2] = byte_of(0.5 + 0.42 * clouded(x));
      out[3] = byte_of(strands(bent(0.08)));
    }
  }

  double strands(const Point& p) const {
    return std::max({film(films[0](p), 0.035), 0.8 * film(films[1](p), 0.06), 0.55 * film(films[2](p), 0.10)});
  }
};

// ---- vessels: trees grown towards points that want blood [Runions2005], on a tile whose edges meet

struct Twig {
  double x = 0, y = 0;
  int parent = -1;
  double radius = 0;  ///< of the tile's width
  int branches = 0;   ///< so far; two at most, one from a root
};

/// A coordinate on the tile, 0 … 1.
double on_tile(double v) {
  return v - below(v);
}

double nearest_image(double d) {
  return d - below(d + 0.5);
}

struct TreePlan {
  int roots, wants;
  double step, reach, tip_radius, widest;
  std::uint32_t seed;
};

struct Want {
  double x, y, best = 1e9;
  int nearest = -1;
};

/// Lets new twigs claim the points nearest to them; points that are reached go.
void claim(std::vector<Want>& wants, const std::vector<Twig>& twigs, std::size_t first, double reached) {
  for (Want& want : wants)
    for (std::size_t k = first; k < twigs.size(); ++k) {
      const double dx = nearest_image(want.x - twigs[k].x), dy = nearest_image(want.y - twigs[k].y);
      const double distance2 = dx * dx + dy * dy;
      if (distance2 < want.best) want.best = distance2, want.nearest = static_cast<int>(k);
    }
  std::erase_if(wants, [&](const Want& want) { return want.best < reached * reached; });
}

std::vector<Twig> grown_twigs(const TreePlan& plan) {
  Dice dice(plan.seed);
  std::vector<Twig> twigs;
  for (int k = 0; k < plan.roots; ++k) {
    const double x = (k + dice()) / plan.roots;
    twigs.push_back({x, dice(), -1, 0, 1});
  }
  std::vector<Want> wants;
  for (int k = 0; k < plan.wants; ++k) {
    const double x = dice();
    wants.push_back({x, dice()});
  }
  const GradientNoise winding(9, plan.seed);
  std::size_t first = 0;
  for (int round = 0; round < 400 && !wants.empty(); ++round) {
    claim(wants, twigs, first, plan.reach);
    first = twigs.size();
    std::vector<std::array<double, 2>> pull(first, {0, 0});
    for (const Want& want : wants) {
      const Twig& twig = twigs[static_cast<std::size_t>(want.nearest)];
      const double dx = nearest_image(want.x - twig.x), dy = nearest_image(want.y - twig.y);
      const double length = std::sqrt(dx * dx + dy * dy);
      pull[static_cast<std::size_t>(want.nearest)][0] += dx / length;
      pull[static_cast<std::size_t>(want.nearest)][1] += dy / length;
    }
    for (std::size_t k = 0; k < first; ++k) {
      const double length = std::sqrt(pull[k][0] * pull[k][0] + pull[k][1] * pull[k][1]);
      if (length < 0.05 || twigs[k].branches == 2) continue;
      ++twigs[k].branches;
      const double sway = 0.5 * (dice() - 0.5) + 1.1 * winding({on_tile(twigs[k].x), on_tile(twigs[k].y), 0.5});
      const double ux = pull[k][0] / length, uy = pull[k][1] / length;
      twigs.push_back({twigs[k].x + plan.step * (ux - sway * uy), twigs[k].y + plan.step * (uy + sway * ux),
                       static_cast<int>(k), 0, 0});
    }
  }
  return twigs;
}

/// Murray's law: a vessel's radius cubed is the sum of its branches' [Murray1926]; roots come up from below.
std::vector<Twig> vessel_tree(const TreePlan& plan) {
  std::vector<Twig> twigs = grown_twigs(plan);
  std::vector<double> tips(twigs.size(), 0), depth(twigs.size(), 0);
  for (std::size_t k = twigs.size(); k-- > 0;) {
    if (tips[k] == 0) tips[k] = 1;
    if (twigs[k].parent >= 0) tips[static_cast<std::size_t>(twigs[k].parent)] += tips[k];
  }
  for (std::size_t k = 0; k < twigs.size(); ++k) {
    // The cube root by Newton's steps.
    double root = 1;
    for (int n = 0; n < 40; ++n) root -= (root * root * root - tips[k]) / (3 * root * root);
    if (twigs[k].parent >= 0) depth[k] = depth[static_cast<std::size_t>(twigs[k].parent)] + plan.step;
    const double risen = 0.15 + 0.85 * smooth_step(0, 0.08, depth[k]);
    twigs[k].radius = std::min(plan.tip_radius * root, plan.widest) * risen;
  }
  return twigs;
}

/// One piece of a vessel, as a round ridge; thin ones lie deeper and show less.
void draw_twig(std::vector<double>& ridge, const Twig& from, const Twig& to, double full_radius) {
  const double dx = to.x - from.x, dy = to.y - from.y, length2 = std::max(dx * dx + dy * dy, 1e-12);
  const double wide = std::max(from.radius, to.radius) + 1.0 / vessel_size;
  const auto texel = [](double v) { return below(v * vessel_size); };
  for (int y = texel(std::min(from.y, to.y) - wide); y <= texel(std::max(from.y, to.y) + wide); ++y)
    for (int x = texel(std::min(from.x, to.x) - wide); x <= texel(std::max(from.x, to.x) + wide); ++x) {
      const double px = (x + 0.5) / vessel_size - from.x, py = (y + 0.5) / vessel_size - from.y;
      const double t = std::clamp((px * dx + py * dy) / length2, 0.0, 1.0);
      const double ex = px - t * dx, ey = py - t * dy;
      const double radius = from.radius + t * (to.radius - from.radius);
      const double soft = std::max(radius, 0.9 / vessel_size);  // thinner than a texel: fainter instead
      const double across = std::max(0.0, 1 - (ex * ex + ey * ey) / (soft * soft));
      const double shown = across * std::min(1.0, std::sqrt(radius / full_radius)) * (radius / soft);
      double& at =
          ridge[static_cast<std::size_t>(wrapped_far(y, vessel_size) * vessel_size + wrapped_far(x, vessel_size))];
      at = std::max(at, shown);
    }
}

std::vector<double> vessel_ridges(const TreePlan& plan) {
  std::vector<double> ridge(static_cast<std::size_t>(vessel_size * vessel_size), 0.0);
  const std::vector<Twig> twigs = vessel_tree(plan);
  for (const Twig& twig : twigs)
    if (twig.parent >= 0) draw_twig(ridge, twigs[static_cast<std::size_t>(twig.parent)], twig, plan.widest);
  return ridge;
}

/// The mean over a box of 2·reach + 1 texels along one axis, around the tile.
std::vector<double> box_mean(const std::vector<double>& in, int reach, bool along_x) {
  std::vector<double> out(in.size());
  const auto at = [&](int along, int line) {
    const int k = wrapped(along, vessel_size);
    return static_cast<std::size_t>(along_x ? line * vessel_size + k : k * vessel_size + line);
  };
  for (int line = 0; line < vessel_size; ++line) {
    double sum = 0;
    for (int k = -reach; k <= reach; ++k) sum += in[at(k, line)];
    for (int k = 0; k < vessel_size; ++k) {
      out[at(k, line)] = sum / (2 * reach + 1);
      sum += in[at(k + reach + 1, line)] - in[at(k - reach, line)];
    }
  }
  return out;
}

}  // namespace

TextureBytes make_tissue_volume(int n) {
  TextureBytes texture{n, n, std::vector<std::uint8_t>(std::size_t{4} * n * n * n)};
  const VolumeFields fields;
  parallel_for(static_cast<std::size_t>(n), [&](std::size_t z) {
    for (int y = 0; y < n; ++y)
      fields.row((y + 0.5) / n, (static_cast<double>(z) + 0.5) / n, n,
                 &texture.rgba[4 * (z * n + static_cast<std::size_t>(y)) * static_cast<std::size_t>(n)]);
  });
  return texture;
}

TextureBytes make_vessel_tile() {
  constexpr int n = vessel_size;
  const std::vector<double> wide = vessel_ridges({3, 420, 0.006, 0.016, 0.0014, 0.011, 5});
  const std::vector<double> fine = vessel_ridges({14, 2600, 0.004, 0.007, 0.0007, 0.0032, 6});
  std::vector<double> flush(wide.size());
  for (std::size_t k = 0; k < wide.size(); ++k) flush[k] = wide[k] + 0.6 * fine[k];
  for (int pass = 0; pass < 3; ++pass) flush = box_mean(box_mean(flush, 7, true), 7, false);
  const Clouds grain(40, 3, 41);
  TextureBytes texture{n, 1, std::vector<std::uint8_t>(std::size_t{4} * n * n)};
  for (int y = 0; y < n; ++y) {
    const Clouds::Row grained(grain, (y + 0.5) / n, 0.37);
    for (int x = 0; x < n; ++x) {
      const auto k = static_cast<std::size_t>(y * n + x);
      texture.rgba[4 * k] = byte_of(wide[k]);
      texture.rgba[4 * k + 1] = byte_of(fine[k]);
      texture.rgba[4 * k + 2] = byte_of(2 * flush[k]);
      texture.rgba[4 * k + 3] = byte_of(0.5 + 0.45 * grained((x + 0.5) / n));
    }
  }
  return texture;
}

// ---- on the graphics card

namespace {

unsigned uploaded(GLenum target, const TextureBytes& t, bool lite) {
  unsigned name = 0;
  glGenTextures(1, &name);
  glBindTexture(target, name);
  if (target == GL_TEXTURE_3D)
    glTexImage3D(target, 0, GL_RGBA8, t.size, t.size, t.depth, 0, GL_RGBA, GL_UNSIGNED_BYTE, t.rgba.data());
  else
    glTexImage2D(target, 0, GL_RGBA8, t.size, t.size, 0, GL_RGBA, GL_UNSIGNED_BYTE, t.rgba.data());
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, lite ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    glTexParameteri(target, axis, GL_REPEAT);
  glGenerateMipmap(target);
  glBindTexture(target, 0);
  return name;
}

}  // namespace

namespace {

// Made once for all contexts of a process; never changed.
const TextureBytes& made_volume(bool lite) {
  if (lite) {
    static const TextureBytes small = make_tissue_volume(small_volume_size);
    return small;
  }
  static const TextureBytes large = make_tissue_volume(volume_size);
  return large;
}

const TextureBytes& made_tile() {
  static const TextureBytes tile = make_vessel_tile();
  return tile;
}

}  // namespace

TissueTextures::TissueTextures(bool lite)
    : volume_(uploaded(GL_TEXTURE_3D, made_volume(lite), lite)), vessels_(uploaded(GL_TEXTURE_2D, made_tile(), lite)) {}

TissueTextures::~TissueTextures() {
  glDeleteTextures(1, &volume_);
  glDeleteTextures(1, &vessels_);
}

void TissueTextures::bind() const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(first_unit));
  glBindTexture(GL_TEXTURE_3D, volume_);
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(first_unit + 1));
  glBindTexture(GL_TEXTURE_2D, vessels_);
}

}  // namespace calot

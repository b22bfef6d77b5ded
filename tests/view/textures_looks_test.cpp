// What tissue.glsl makes of each look, read back as numbers.
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "calot/view/gl/context.h"
#include "calot/view/gl/objects.h"
#include "calot/view/gl/shader_text.h"
#include "calot/view/snapshot.h"
#include "calot/view/textures.h"

namespace calot {
namespace {

using detail::GlProgram;
using Color = Eigen::Vector3d;

constexpr int side = 160;
constexpr int looks = 8;
const char* const names[looks] = {"soft", "liver", "gallbladder", "duct", "artery", "fat", "bed", "peritoneum"};

const char* const everywhere =
    "#version 330 core\nvoid main() { gl_Position = vec4(vec2(gl_VertexID & 1, "
    "gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }\n";

// A flat patch (ball 0) or the front of a ball of that radius.
const char* const sampling_text = R"(
uniform vec4 condition, mask;
uniform float spacing, ball;
uniform int look;
uniform bool cut, lite;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 shine;
void main() {
  vec2 p = (gl_FragCoord.xy - 80.0) * spacing;
  vec3 rest = vec3(p, 0.3 * p.x - 0.2 * p.y), normal = normalize(vec3(-0.3, 0.2, 1.0));
  if (ball > 0.0) rest = vec3(p, sqrt(max(ball * ball - dot(p, p), 1e-12))), normal = normalize(rest);
  Material m = tissue(look, cut, rest, normal, condition, mask, lite);
  colour = vec4(m.base, m.height);
  shine = vec4(m.roughness, m.coat, m.coat_roughness, m.ao);
}
)";

struct Patch {
  std::vector<float> colour, shine;  ///< side² × 4
};

struct Sampling {
  Eigen::Vector4f condition = Eigen::Vector4f::Zero(), mask = Eigen::Vector4f::Zero();
  float spacing = 0.24e-3F, ball = 0;  ///< [m]
};

/// One program for all looks; the renderer's programs have them as constants.
class TissueShader {
 public:
  TissueShader() : program_(GlProgram::make()) {
    attach(GL_VERTEX_SHADER, everywhere);
    attach(GL_FRAGMENT_SHADER, detail::assemble_shader("tissue.glsl", {}).text + sampling_text);
    glLinkProgram(program_.number());
    GLint good = 0;
    glGetProgramiv(program_.number(), GL_LINK_STATUS, &good);
    EXPECT_NE(good, 0);
    glUseProgram(program_.number());
    glUniform1i(place("tissue_noise"), TissueTextures::first_unit);
    glUniform1i(place("tissue_detail"), TissueTextures::first_unit + 1);
  }

  Patch sample(int look, bool cut, const Sampling& s, bool lite) const {
    glUseProgram(program_.number());
    glUniform1i(place("look"), look);
    glUniform1i(place("cut"), cut ? 1 : 0);
    glUniform1i(place("lite"), lite ? 1 : 0);
    glUniform4fv(place("condition"), 1, s.condition.data());
    glUniform4fv(place("mask"), 1, s.mask.data());
    glUniform1f(place("spacing"), s.spacing);
    glUniform1f(place("ball"), s.ball);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    Patch patch{std::vector<float>(4 * side * side), std::vector<float>(4 * side * side)};
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, side, side, GL_RGBA, GL_FLOAT, patch.colour.data());
    glReadBuffer(GL_COLOR_ATTACHMENT1);
    glReadPixels(0, 0, side, side, GL_RGBA, GL_FLOAT, patch.shine.data());
    return patch;
  }

 private:
  void attach(GLenum stage, const std::string& text) {
    const GLuint shader = glCreateShader(stage);
    const char* source = text.c_str();
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint good = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    char log[1000] = "";
    glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    EXPECT_NE(good, 0) << log;
    glAttachShader(program_.number(), shader);
    glDeleteShader(shader);
  }
  GLint place(const char* name) const { return glGetUniformLocation(program_.number(), name); }
  GlProgram program_;
};

class TissueLooks : public testing::Test {
 protected:
  TissueLooks() {
    glBindVertexArray(vertices_.number());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.number());
    const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    for (int k = 0; k < 2; ++k) {
      glActiveTexture(GL_TEXTURE0);
      glBindTexture(GL_TEXTURE_2D, targets_[k].number());
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, side, side, 0, GL_RGBA, GL_FLOAT, nullptr);
      glFramebufferTexture2D(GL_FRAMEBUFFER, both[k], GL_TEXTURE_2D, targets_[k].number(), 0);
    }
    glDrawBuffers(2, both);
    glViewport(0, 0, side, side);
  }
  ~TissueLooks() override {
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    EXPECT_TRUE(context_.log().silent()) << context_.log().messages().front();
  }

  Patch patch(int look, bool cut, const Sampling& sampling = {}, bool lite = false) {
    std::unique_ptr<TissueTextures>& textures = textures_[lite ? 1 : 0];
    if (!textures) textures = std::make_unique<TissueTextures>(lite);
    textures->bind();
    return shader_.sample(look, cut, sampling, lite);
  }

 private:
  OffscreenContext context_;
  std::unique_ptr<TissueTextures> textures_[2];
  TissueShader shader_;
  detail::GlVertexArray vertices_ = detail::GlVertexArray::make();
  detail::GlFramebuffer framebuffer_ = detail::GlFramebuffer::make();
  detail::GlTexture targets_[2] = {detail::GlTexture::make(), detail::GlTexture::make()};
};

Color mean_of(const Patch& patch) {
  Color sum = Color::Zero();
  for (std::size_t k = 0; k < patch.colour.size(); k += 4)
    sum += Color(patch.colour[k], patch.colour[k + 1], patch.colour[k + 2]);
  return sum / (side * side);
}

/// CIE L*a*b* (D65) of linear sRGB.
Color lab(const Color& rgb) {
  Eigen::Matrix3d xyz;
  xyz << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Color v = (xyz * rgb).cwiseQuotient(Color(0.9505, 1, 1.089));
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  return {116 * f(v.y()) - 16, 500 * (f(v.x()) - f(v.y())), 200 * (f(v.y()) - f(v.z()))};
}

/// As eyes without the green cones see it [Vienot1999].
Color without_green_cones(const Color& rgb) {
  Eigen::Matrix3d m;
  m << 0.29275, 0.70725, 0, 0.29275, 0.70725, 0, -0.02234, 0.02234, 1;
  return (m * rgb).cwiseMax(0);
}

double lightness(const Color& rgb) {
  return lab(rgb).x();
}

TEST_F(TissueLooks, AreMaterialsUnderAnyConditionAndMask) {
  const Sampling all[] = {{},
                          {{1, 0, 0, 0}, {0, 0, 0, 0}},
                          {{1, 1, 0, 0}, {0, 0, 0, 1}},
                          {{0, 0, 1, 1}, {0, 0, 0, 1}},
                          {{0.4F, 0.3F, 0.2F, 0.5F}, {0.4F, 0.2F, 0.3F, 0.5F}},
                          {{0, 0, 0, 0}, {1, 0, 1, 1}}};
  for (int look = 0; look < looks; ++look)
    for (const bool cut : {false, true})
      for (const Sampling& sampling : all) {
        const Patch p = patch(look, cut, sampling);
        bool good = true;
        for (std::size_t k = 0; k < p.colour.size(); ++k) {
          const float v = p.colour[k];
          good = good && (k % 4 == 3 ? std::abs(v) < 1.5e-3F : v > 0.001F && v < 0.95F);
          good = good && p.shine[k] >= (k % 4 == 0 || k % 4 == 2 ? 0.05F : 0.0F) && p.shine[k] <= 1.0F;
        }
        EXPECT_TRUE(good) << names[look] << (cut ? " cut" : "") << sampling.condition.transpose() << " | "
                          << sampling.mask.transpose();
      }
}

TEST_F(TissueLooks, ReliefHasNoJumpAnywhereOnABall) {
  for (int look = 0; look < looks; ++look)
    for (const bool lite : {false, true}) {
      Sampling fine{{0.5F, 0, 0, 0}, {0.4F, 0, 0, 0}};
      fine.ball = 9e-3F, fine.spacing = 0.055e-3F;  // all three planes, and where they meet
      const Patch p = patch(look, false, fine, lite);
      double steepest = 0;
      for (int y = 0; y < side; ++y)
        for (int x = 1; x < side; ++x) {
          const auto k = static_cast<std::size_t>(4 * (y * side + x) + 3);
          steepest = std::max(steepest, std::abs(static_cast<double>(p.colour[k]) - p.colour[k - 4]) / fine.spacing);
        }
      EXPECT_LT(steepest, 2.0) << names[look] << (lite ? " lite" : "");
      EXPECT_GT(steepest, 0.01) << names[look];
    }
}

TEST_F(TissueLooks, HaveTheColoursOfTissue) {
  struct Range {
    double light_low, light_high, hue_low, hue_high;  // hue [degrees] of L*a*b*
  };
  const Range ranges[looks] = {{40, 62, 20, 60}, {18, 34, 25, 60}, {45, 62, 90, 150}, {58, 76, 70, 105},
                               {40, 58, 15, 45}, {62, 80, 60, 90}, {35, 55, 15, 50},  {50, 68, 25, 70}};
  for (int look = 0; look < looks; ++look) {
    const Color c = lab(mean_of(patch(look, false)));
    const double hue = std::atan2(c.z(), c.y()) * 180 / 3.14159265358979;
    const Range& r = ranges[look];
    EXPECT_TRUE(c.x() > r.light_low && c.x() < r.light_high) << names[look] << " L " << c.x();
    EXPECT_TRUE(hue > r.hue_low && hue < r.hue_high) << names[look] << " hue " << hue;
  }
}

TEST_F(TissueLooks, AreToldApartWithoutRedAndGreen) {
  Color seen[looks];
  for (int look = 0; look < looks; ++look) seen[look] = lab(without_green_cones(mean_of(patch(look, false))));
  for (int a = 0; a < looks; ++a)
    for (int b = 0; b < a; ++b) EXPECT_GT((seen[a] - seen[b]).norm(), 5) << names[a] << " and " << names[b];
  // What a surgeon must not take for the other differs in lightness alone.
  const std::array<TissueLook, 2> pairs[] = {
      {TissueLook::duct, TissueLook::artery},       {TissueLook::duct, TissueLook::gallbladder},
      {TissueLook::duct, TissueLook::liver},        {TissueLook::artery, TissueLook::fat},
      {TissueLook::gallbladder, TissueLook::liver}, {TissueLook::gallbladder, TissueLook::fat},
      {TissueLook::bed, TissueLook::gallbladder},   {TissueLook::bed, TissueLook::liver}};
  for (const auto& [a, b] : pairs) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    EXPECT_GT(std::abs(seen[i].x() - seen[j].x()), 6) << names[i] << " and " << names[j];
  }
}

TEST_F(TissueLooks, ShowDetailAtTheirOwnScale) {
  for (int look = 0; look < looks; ++look)
    for (const bool cut : {false, true}) {
      const Patch p = patch(look, cut);
      double sum = 0, squares = 0;
      for (std::size_t k = 0; k < p.colour.size(); k += 4) {
        const double l = lightness(Color(p.colour[k], p.colour[k + 1], p.colour[k + 2]));
        sum += l, squares += l * l;
      }
      const double n = side * side, deviation = std::sqrt(squares / n - sum / n * sum / n);
      EXPECT_GT(deviation, 1.0) << names[look] << (cut ? " cut" : "") << ": plastic";
      EXPECT_LT(deviation, 14) << names[look] << (cut ? " cut" : "") << ": camouflage";
    }
}

TEST_F(TissueLooks, LiteHasTheSameColours) {
  for (int look = 0; look < looks; ++look)
    for (const bool cut : {false, true}) {
      const Color full = lab(mean_of(patch(look, cut))), lite = lab(mean_of(patch(look, cut, {}, true)));
      EXPECT_LT((full - lite).norm(), 3) << names[look] << (cut ? " cut" : "");
    }
}

TEST_F(TissueLooks, HeatBruisesAndPressureChangeThem) {
  for (int look = 0; look < looks; ++look) {
    const auto color = [&](const Eigen::Vector4f& condition) {
      Sampling s;
      s.condition = condition;
      return mean_of(patch(look, false, s));
    };
    const Color fresh = color({0, 0, 0, 0}), boiled = color({1, 0, 0, 0}), burnt = color({1, 1, 0, 0});
    const auto chroma = [](const Color& c) { return lab(c).tail<2>().norm(); };
    if (look != static_cast<int>(TissueLook::gallbladder)) {  // it has little colour to lose
      EXPECT_LT(chroma(boiled), chroma(fresh)) << names[look];
    }
    EXPECT_LT(lightness(burnt), 22) << names[look];
    EXPECT_GT(lightness(burnt), 4) << names[look] << ": nothing is quite black";
    EXPECT_GT(lightness(color({0, 0, 1, 0})), lightness(fresh)) << names[look];
    const Color bruised = color({0, 0, 0, 1});
    EXPECT_LT(lab(bruised).z(), lab(fresh).z() - 3) << names[look] << ": bluer";
  }
  const auto liver = static_cast<int>(TissueLook::liver);
  Sampling boiled;
  boiled.condition.x() = 1;
  EXPECT_GT(lightness(mean_of(patch(liver, false, boiled))), lightness(mean_of(patch(liver, false))) + 10);
}

TEST_F(TissueLooks, BloodAndBileCoverWithRaggedEdges) {
  for (int look = 0; look < looks; ++look) {
    Sampling s;
    s.mask = {1, 0, 0, 0};
    const Color blood = mean_of(patch(look, false, s));
    EXPECT_GT(blood.x(), 6 * blood.y()) << names[look];
    EXPECT_LT(lightness(blood), 30) << names[look];
    s.mask = {0, 0, 1, 0};
    const Color bile = mean_of(patch(look, false, s));
    EXPECT_TRUE(bile.x() > bile.y() && bile.y() > 5 * bile.z()) << names[look];
    // Where the mask is low everywhere, some places are covered and some are not: no even veil.
    s.mask = {0.28F, 0, 0, 0};
    const Patch edge = patch(look, false, s), dry = patch(look, false);
    int covered = 0, bare = 0;
    for (std::size_t k = 0; k < edge.colour.size(); k += 4) {
      const float left = edge.colour[k + 1] / dry.colour[k + 1];  // of the green light
      covered += left < 0.5F ? 1 : 0;
      bare += left > 0.95F ? 1 : 0;
    }
    EXPECT_GT(covered, side * side / 20) << names[look];
    EXPECT_GT(bare, side * side / 20) << names[look];
  }
}

TEST_F(TissueLooks, WetTissueShinesMoreAndACrustLess) {
  const auto shine = [&](const Sampling& s, std::size_t which) {
    const Patch p = patch(static_cast<int>(TissueLook::liver), false, s);
    double sum = 0;
    for (std::size_t k = which; k < p.shine.size(); k += 4) sum += p.shine[k];
    return sum / (side * side);
  };
  Sampling wet, burnt;
  wet.mask.w() = 1;
  burnt.condition.y() = 1;
  EXPECT_GT(shine(wet, 1), shine({}, 1) + 0.1);
  EXPECT_LT(shine(wet, 2), shine({}, 2));
  EXPECT_LT(shine(burnt, 1), 0.05);
  EXPECT_GT(shine(burnt, 0), 0.85);
}

}  // namespace
}  // namespace calot

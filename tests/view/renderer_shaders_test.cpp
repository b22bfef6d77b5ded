// Every shader compiles; text is put together as promised.
#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "calot/view/gl/program.h"
#include "calot/view/gl/shader_text.h"
#include "tests/view/renderer_picture.h"

namespace calot {
namespace {

TEST(RendererShaders, EveryVariantCompilesAndTheDriverIsSilent) {
  OffscreenContext& context = test::shared_context();
  context.make_current();
  context.log().clear();
  ASSERT_TRUE(context.log().listens());
  EXPECT_GE(compile_all_shaders(), 80U);
  for (const std::string& message : context.log().messages()) ADD_FAILURE() << message;
}

TEST(RendererShaders, ADefinitionAndAnIncludeComeBeforeTheTextThatUsesThem) {
  const std::vector<std::string> definitions{"LITE", "LOOK 3"};
  const detail::AssembledShader shader = detail::assemble_shader("surface_fragment.glsl", definitions);
  EXPECT_EQ(shader.text.rfind("#version 330 core\n#define LITE\n#define LOOK 3\n", 0), 0U);
  EXPECT_EQ(shader.text.find("#include"), std::string::npos);
  EXPECT_LT(shader.text.find("uniform Frame"), shader.text.find("void main"));
  EXPECT_EQ(shader.files.front(), "surface_fragment.glsl");
  EXPECT_EQ(std::count(shader.files.begin(), shader.files.end(), "frame.glsl"), 1);
}

TEST(RendererShaders, AnUnknownShaderAndABrokenOneAreTold) {
  test::shared_context().make_current();
  EXPECT_THROW((void)detail::assemble_shader("no_such.glsl", {}), FailedError);
  try {
    const detail::Program program({"surface_vertex.glsl", "tone.glsl", {"SHADOW this is no code }"}});
    FAIL() << "compiled";
  } catch (const FailedError& error) {
    EXPECT_NE(std::string(error.what()).find("surface_vertex.glsl"), std::string::npos) << error.what();
  }
}

TEST(RendererShaders, TheLogHearsAMistake) {
  OffscreenContext& context = test::shared_context();
  context.make_current();
  context.log().clear();
  glBindTexture(GL_TEXTURE_2D, 0xdead);
  glEnable(0xffff);
  EXPECT_FALSE(context.log().silent());
  while (glGetError() != GL_NO_ERROR) {
  }
  context.log().clear();
}

}  // namespace
}  // namespace calot

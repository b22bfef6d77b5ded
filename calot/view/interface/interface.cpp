#include "calot/view/interface/interface.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/view/interface/interface_gl.h"
#include "calot/view/interface/pages.h"

namespace calot {
namespace {

constexpr const char* other_letters = "–…·°µ";  // that states bring along

struct ContextEnd {
  void operator()(ImGuiContext* context) const { ImGui::DestroyContext(context); }
};

std::string letters_of(const InterfaceState& state) {
  std::string all = other_letters + state.step + state.hint;
  for (const InterfaceMessage& message : state.messages) all += message.text;
  for (const InterfaceDevice& device : state.devices) all += device.name;
  for (const std::string& key : state.command_keys) all += key;
  for (const InterfaceControl& control : state.controls) {
    all += control.words;
    for (const std::string& key : control.keys) all += key;
  }
  return all;
}

void pass_input(const InterfaceInput& input, bool modal) {
  ImGuiIO& io = ImGui::GetIO();
  io.DeltaTime = static_cast<float>(std::clamp(input.seconds, 1e-4, 1.0));
  io.MousePos = input.pointer ? ImVec2(static_cast<float>((*input.pointer)[0]), static_cast<float>((*input.pointer)[1]))
                              : ImVec2(-FLT_MAX, -FLT_MAX);
  io.MouseDown[0] = input.pressed && input.pointer.has_value();
  io.MouseWheel = static_cast<float>(input.wheel);
  const std::pair<ImGuiKey, bool> keys[] = {{ImGuiKey_UpArrow, input.up},     {ImGuiKey_DownArrow, input.down},
                                            {ImGuiKey_LeftArrow, input.left}, {ImGuiKey_RightArrow, input.right},
                                            {ImGuiKey_Tab, input.next},       {ImGuiKey_Space, input.accept}};
  for (const auto& [key, down] : keys) io.KeysDown[io.KeyMap[key]] = modal && down;
}

void check_size(int width, int height) {
  if (width < 64 || height < 64 || width > 8192 || height > 8192)
    throw InputError("interface", "a picture of " + std::to_string(width) + " × " + std::to_string(height) + " pixels",
                     "ask for 64 to 8192 pixels each way");
}

}  // namespace

struct Interface::Parts {
  TextTable texts;
  std::string letters;  // of the texts
  std::unique_ptr<ImGuiContext, ContextEnd> context;
  detail::Fonts fonts;
  detail::Pages pages;
  std::unique_ptr<detail::InterfaceGl> gl;
  bool new_font = true;
  InterfaceLayout layout;
};

Interface::Interface(TextTable text) : parts_(std::make_unique<Parts>()) {
  parts_->texts = std::move(text);
  parts_->letters = parts_->texts.letters();
  parts_->context.reset(ImGui::CreateContext());
  ImGui::SetCurrentContext(parts_->context.get());
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
}

Interface::~Interface() = default;

void Interface::show_help() {
  parts_->pages.open(detail::Page::help);
}

InterfaceActions Interface::lay_out(const InterfaceState& state, const InterfaceInput& input, int width, int height,
                                    double pixel_ratio) {
  check_size(width, height);
  Parts& p = *parts_;
  ImGui::SetCurrentContext(p.context.get());
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  const detail::Measures measures = detail::measures_of(state, width, height, pixel_ratio);
  const detail::Palette palette = detail::palette_of(state.settings.colors);
  if (p.fonts.prepare(*io.Fonts, measures, p.letters + letters_of(state))) p.new_font = true;
  io.FontDefault = p.fonts.text();
  detail::apply_style(palette, measures);

  InterfaceActions actions;
  for (const InterfaceCommand command : input.commands) p.pages.take(command, state, actions);
  pass_input(input, p.pages.page() != detail::Page::none || state.paused);
  ImGui::NewFrame();
  const detail::Pen pen{ImGui::GetBackgroundDrawList(), palette, measures, p.fonts, p.texts, state};
  detail::draw_display(pen);
  const auto places = detail::draw_commands(pen);
  p.pages.draw(pen, actions);
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse)
    for (const detail::CommandPlace& place : places)
      if (ImGui::IsMouseHoveringRect(place.low, place.high, false)) p.pages.take(place.command, state, actions);
  ImGui::Render();
  actions.modal = p.pages.page() != detail::Page::none || state.paused;
  const ImDrawData& data = *ImGui::GetDrawData();
  p.layout = {measures.text, static_cast<std::size_t>(data.TotalVtxCount),
              static_cast<std::size_t>(data.TotalIdxCount / 3)};
  return actions;
}

void Interface::draw() {
  Parts& p = *parts_;
  ImGui::SetCurrentContext(p.context.get());
  const ImDrawData* data = ImGui::GetDrawData();
  if (data == nullptr) return;  // nothing was laid out yet
  if (p.gl == nullptr) {
    p.gl = std::make_unique<detail::InterfaceGl>();
    p.new_font = true;
  }
  if (p.new_font) p.gl->set_font(*ImGui::GetIO().Fonts);
  p.new_font = false;
  p.gl->draw(*data);
}

void Interface::release() {
  parts_->gl.reset();
}

InterfaceLayout Interface::layout() const {
  return parts_->layout;
}

std::vector<std::array<float, 3>> Interface::corners() const {
  ImGui::SetCurrentContext(parts_->context.get());
  const ImDrawData* data = ImGui::GetDrawData();
  std::vector<std::array<float, 3>> all;
  for (int k = 0; data != nullptr && k < data->CmdListsCount; ++k)
    for (const ImDrawIdx index : data->CmdLists[k]->IdxBuffer) {
      const ImDrawVert& v = data->CmdLists[k]->VtxBuffer[index];
      all.push_back({v.pos.x, v.pos.y, static_cast<float>(v.col >> 24U) / 255});
    }
  return all;
}

}  // namespace calot

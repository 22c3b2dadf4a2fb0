#include "app/view_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <thread>
#include <utility>

#include "render/context.h"

namespace tellurion::app {

namespace {

/// A key or a character for the panels.
struct Typed {
  int key = 0;
  int scancode = 0;
  int action = 0;
  int modifiers = 0;
  unsigned int character = 0;  ///< else a key
};

struct Heard {
  std::vector<InputEvent> events;
  std::deque<Typed> typed;         ///< waits until a field of text is ready for it
  bool typing = false;             ///< a panel that has a field of text is open
  bool swallowsCharacter = false;  ///< that of the key which opened it
  bool motion = false;             ///< keys lead the eye
  /// Where the cursor was at the last event; the window system itself only knows where it is by now.
  scene::PixelPosition cursor;
};

}  // namespace

struct ViewWindow::State {
  GLFWwindow* window = nullptr;
  bool panels = false;
  Heard heard;
  /// Software drivers, remote displays and settings of a driver do not wait for the screen: more pictures than it can
  /// show would only take the processor from the tiles that load.
  std::chrono::steady_clock::duration leastBetweenPictures{};
  std::chrono::steady_clock::time_point shown;

  ~State() {
    if (panels) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext();
    }
    if (window) glfwDestroyWindow(window);
    glfwTerminate();
  }
};

namespace {

Heard& heardBy(GLFWwindow* window) {
  return *static_cast<Heard*>(glfwGetWindowUserPointer(window));
}

/// X tells whole pixels: what is pointed at is the middle of one.
scene::PixelPosition pixelFrom(GLFWwindow* window, double x, double y) {
  int windowWidth = 0, windowHeight = 0, width = 0, height = 0;
  glfwGetWindowSize(window, &windowWidth, &windowHeight);
  glfwGetFramebufferSize(window, &width, &height);
  return {(x + 0.5) * width / std::max(windowWidth, 1), (y + 0.5) * height / std::max(windowHeight, 1)};
}

Modifiers modifiersFrom(int mods) {
  return {(mods & GLFW_MOD_SHIFT) != 0, (mods & GLFW_MOD_CONTROL) != 0};
}

/// Buttons and the wheel over a panel are the panel's. What was begun on the picture goes on there.
bool panelTakes(GLFWwindow* window) {
  if (!ImGui::GetIO().WantCaptureMouse) return false;
  heardBy(window).events.emplace_back(PanelTouched{});
  return true;
}

void onButton(GLFWwindow* window, int button, int action, int mods) {
  ImGui_ImplGlfw_MouseButtonCallback(window, button, action, mods);
  if (panelTakes(window) && action == GLFW_PRESS) return;
  if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
  const MouseButton which = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::left
                            : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::right
                                                                : MouseButton::middle;
  Heard& heard = heardBy(window);
  heard.events.emplace_back(
      ButtonChanged{which, action == GLFW_PRESS, modifiersFrom(mods), heard.cursor, glfwGetTime()});
}

// Only the last of several moves counts: gestures are functions of where the cursor is.
void onCursor(GLFWwindow* window, double x, double y) {
  Heard& heard = heardBy(window);
  heard.cursor = pixelFrom(window, x, y);
  if (!heard.events.empty() && std::holds_alternative<CursorMoved>(heard.events.back())) heard.events.pop_back();
  heard.events.emplace_back(CursorMoved{heard.cursor, glfwGetTime()});
}

void onEnter(GLFWwindow* window, int entered) {
  ImGui_ImplGlfw_CursorEnterCallback(window, entered);
  if (!entered) heardBy(window).events.emplace_back(CursorLeft{});
}

void onScroll(GLFWwindow* window, double across, double steps) {
  ImGui_ImplGlfw_ScrollCallback(window, across, steps);
  if (panelTakes(window)) return;
  Heard& heard = heardBy(window);
  heard.events.emplace_back(WheelTurned{steps, heard.cursor});
}

/// What stands beside a key in a table of pairs.
template <class Table>
auto meaningOf(int key, const Table& table) -> std::optional<typename Table::value_type::second_type> {
  const auto found = std::find_if(table.begin(), table.end(), [key](const auto& k) { return k.first == key; });
  if (found == table.end()) return std::nullopt;
  return found->second;
}

std::optional<ViewKey> keyFrom(int key) {
  constexpr std::array<std::pair<int, ViewKey>, 48> kKeys{{
      {GLFW_KEY_EQUAL, ViewKey::plus},
      {GLFW_KEY_KP_ADD, ViewKey::plus},
      {GLFW_KEY_MINUS, ViewKey::minus},
      {GLFW_KEY_KP_SUBTRACT, ViewKey::minus},
      {GLFW_KEY_LEFT, ViewKey::left},
      {GLFW_KEY_RIGHT, ViewKey::right},
      {GLFW_KEY_UP, ViewKey::up},
      {GLFW_KEY_DOWN, ViewKey::down},
      {GLFW_KEY_PAGE_UP, ViewKey::plus},
      {GLFW_KEY_PAGE_DOWN, ViewKey::minus},
      {GLFW_KEY_N, ViewKey::north},
      {GLFW_KEY_R, ViewKey::reset},
      {GLFW_KEY_HOME, ViewKey::reset},
      {GLFW_KEY_L, ViewKey::light},
      {GLFW_KEY_O, ViewKey::air},
      {GLFW_KEY_I, ViewKey::layers},
      {GLFW_KEY_C, ViewKey::printCamera},
      {GLFW_KEY_H, ViewKey::help},
      {GLFW_KEY_F1, ViewKey::help},
      {GLFW_KEY_F12, ViewKey::screenshot},
      {GLFW_KEY_Q, ViewKey::quit},
      {GLFW_KEY_ESCAPE, ViewKey::escape},
      {GLFW_KEY_P, ViewKey::printCamera},
      {GLFW_KEY_1, ViewKey::wireframe},
      {GLFW_KEY_2, ViewKey::levels},
      {GLFW_KEY_3, ViewKey::error},
      {GLFW_KEY_4, ViewKey::boxes},
      {GLFW_KEY_F, ViewKey::freeze},
      {GLFW_KEY_PERIOD, ViewKey::higher},
      {GLFW_KEY_COMMA, ViewKey::lower},
      {GLFW_KEY_S, ViewKey::statistics},
      {GLFW_KEY_F3, ViewKey::statistics},
      {GLFW_KEY_A, ViewKey::automatic},
      {GLFW_KEY_SPACE, ViewKey::play},
      {GLFW_KEY_SEMICOLON, ViewKey::earlier},
      {GLFW_KEY_APOSTROPHE, ViewKey::later},
      {GLFW_KEY_LEFT_BRACKET, ViewKey::coarser},
      {GLFW_KEY_RIGHT_BRACKET, ViewKey::finer},
      {GLFW_KEY_G, ViewKey::goTo},
      {GLFW_KEY_B, ViewKey::bookmarks},
      {GLFW_KEY_K, ViewKey::addKeyFrame},
      {GLFW_KEY_J, ViewKey::keyFrames},
      {GLFW_KEY_F9, ViewKey::record},
      {GLFW_KEY_M, ViewKey::inertia},
      {GLFW_KEY_V, ViewKey::settings},
      {GLFW_KEY_T, ViewKey::walk},
      {GLFW_KEY_U, ViewKey::fly},
      {GLFW_KEY_E, ViewKey::sources},
  }};
  return meaningOf(key, kKeys);
}

bool repeats(ViewKey key) {
  return key <= ViewKey::down;
}

// Letters go by what is printed on the key, also on keyboards with another layout.
std::optional<ViewKey> namedKey(int key, int scancode) {
  const char* name = glfwGetKeyName(key, scancode);
  if (!name || name[1] != '\0') return keyFrom(key);
  if (name[0] >= 'a' && name[0] <= 'z') return keyFrom(GLFW_KEY_A + (name[0] - 'a'));
  if (name[0] == '+' || name[0] == '=') return ViewKey::plus;
  if (name[0] == '-') return ViewKey::minus;
  return keyFrom(key);
}

constexpr std::array<std::pair<int, MotionKey>, 12> kMotion{{
    {GLFW_KEY_W, MotionKey::ahead},
    {GLFW_KEY_S, MotionKey::back},
    {GLFW_KEY_A, MotionKey::left},
    {GLFW_KEY_D, MotionKey::right},
    {GLFW_KEY_UP, MotionKey::ahead},
    {GLFW_KEY_DOWN, MotionKey::back},
    {GLFW_KEY_LEFT, MotionKey::left},
    {GLFW_KEY_RIGHT, MotionKey::right},
    {GLFW_KEY_PAGE_UP, MotionKey::up},
    {GLFW_KEY_PAGE_DOWN, MotionKey::down},
    {GLFW_KEY_LEFT_SHIFT, MotionKey::faster},
    {GLFW_KEY_RIGHT_SHIFT, MotionKey::faster},
}};

/// A release is told whoever has the keys: nothing stays down. True: the key is for nothing else.
bool motionTakes(Heard& heard, int key, int action, bool typing) {
  if (!heard.motion) return false;
  const auto motion = meaningOf(key, kMotion);
  if (!motion || (typing && action != GLFW_RELEASE)) return false;
  if (action != GLFW_REPEAT) heard.events.emplace_back(MotionKeyChanged{*motion, action == GLFW_PRESS});
  return !typing;
}

void onKey(GLFWwindow* window, int key, int scancode, int action, int mods) {
  Heard& heard = heardBy(window);
  heard.swallowsCharacter = false;
  const bool typing = heard.typing || ImGui::GetIO().WantTextInput;
  if (motionTakes(heard, key, action, typing)) return;
  if (typing) {
    heard.typed.push_back({key, scancode, action, mods});
    if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) heard.events.emplace_back(KeyPressed{ViewKey::escape, {}});
    heard.events.emplace_back(PanelTouched{});
    return;
  }
  if (action == GLFW_RELEASE) return;
  auto which = namedKey(key, scancode);
  if (which == ViewKey::freeze && (mods & GLFW_MOD_CONTROL) != 0) which = ViewKey::goTo;
  if (!which || (action != GLFW_PRESS && !repeats(*which))) return;
  heard.events.emplace_back(KeyPressed{*which, modifiersFrom(mods)});
  // What is typed next is for the panel, also where the program has not come to open it yet.
  heard.typing = heard.swallowsCharacter = which == ViewKey::goTo || which == ViewKey::sources;
}

void onCharacter(GLFWwindow* window, unsigned int character) {
  Heard& heard = heardBy(window);
  const bool swallows = std::exchange(heard.swallowsCharacter, false);
  if (swallows || (!heard.typing && !ImGui::GetIO().WantTextInput)) return;
  heard.typed.push_back({.character = character});
  heard.events.emplace_back(PanelTouched{});
}

void onLost(GLFWwindow* window) {
  heardBy(window).events.emplace_back(PictureLost{});
}
void onResized(GLFWwindow* window, int, int) {
  onLost(window);
}
void onIconified(GLFWwindow* window, int) {
  onLost(window);
}

void listen(GLFWwindow* window, Heard& heard) {
  glfwSetWindowUserPointer(window, &heard);
  glfwSetMouseButtonCallback(window, onButton);
  glfwSetCursorPosCallback(window, onCursor);
  glfwSetCursorEnterCallback(window, onEnter);
  glfwSetScrollCallback(window, onScroll);
  glfwSetKeyCallback(window, onKey);
  glfwSetCharCallback(window, onCharacter);
  glfwSetWindowRefreshCallback(window, onLost);
  glfwSetFramebufferSizeCallback(window, onResized);
  glfwSetWindowIconifyCallback(window, onIconified);
}

tl::unexpected<io::Failure> noWindow(std::string_view what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return io::fail(
      io::Failure::Code::unsupported,
      fmt::format("{} ({}); without a display, 'tellurion render SCENE --camera C --size WxH -o picture.png' "
                  "draws the same picture into a file",
                  what, reason ? reason : "no reason given"),
      {});
}

scene::Viewport fitting(scene::Viewport size) {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  if (!monitor) return size;
  int x = 0, y = 0, width = 0, height = 0;
  glfwGetMonitorWorkarea(monitor, &x, &y, &width, &height);
  if (width <= 0 || height <= 0) return size;
  return {std::min(size.width, width), std::min(size.height, height)};
}

std::string screensText() {
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  std::string text;
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* const mode = glfwGetVideoMode(monitors[i]);
    text += fmt::format("{}{} is {}", i > 0 ? ", " : "", i + 1, glfwGetMonitorName(monitors[i]));
    if (mode != nullptr) text += fmt::format(", {}x{}", mode->width, mode->height);
  }
  return text.empty() ? "there is none" : text;
}

/// Null: there is no such screen.
GLFWmonitor* screenOfNumber(int number) {
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  return number >= 1 && number <= count ? monitors[number - 1] : nullptr;
}

/// screen: to fill, in the mode that it is in; null: a window.
GLFWwindow* createWindow(const std::string& title, scene::Viewport size, GLFWmonitor* screen) {
  const GLFWvidmode* const mode = screen != nullptr ? glfwGetVideoMode(screen) : nullptr;
  if (mode != nullptr) {
    size = {mode->width, mode->height};
    glfwWindowHint(GLFW_RED_BITS, mode->redBits);
    glfwWindowHint(GLFW_GREEN_BITS, mode->greenBits);
    glfwWindowHint(GLFW_BLUE_BITS, mode->blueBits);
    glfwWindowHint(GLFW_REFRESH_RATE, mode->refreshRate);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);  // a projector goes on while another window has the keyboard
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);  // the picture's own framebuffer has the depth
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "tellurion");
  return glfwCreateWindow(size.width, size.height, title.c_str(), screen, nullptr);
}

/// uiScale: WindowOptions'.
bool startPanels(GLFWwindow* window, double uiScale) {
  constexpr float kLetters = 13.0f;
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NoMouseCursorChange;
  float scale = 1.0f, ignored = 1.0f;
  glfwGetWindowContentScale(window, &scale, &ignored);
  int windowWidth = 1, width = 1;
  glfwGetWindowSize(window, &windowWidth, nullptr);
  glfwGetFramebufferSize(window, &width, nullptr);
  const float asked = scale * static_cast<float>(windowWidth) / static_cast<float>(std::max(width, 1));
  const float units = uiScale > 0.0 ? static_cast<float>(uiScale) : std::max(asked, 1.0f);
  ImFontConfig font;
  font.SizePixels = std::round(kLetters * units);
  ImGui::GetStyle().ScaleAllSizes(units);
  io.Fonts->AddFontDefault(&font);
  return ImGui_ImplGlfw_InitForOpenGL(window, false) && ImGui_ImplOpenGL3_Init("#version 450 core");
}

/// Of the fastest screen; a little less than its time, for a driver that does wait decides better.
std::chrono::steady_clock::duration leastTimeBetweenPictures() {
  constexpr int kUsualRate_hz = 60;
  int rate_hz = 0;
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  for (int i = 0; i < count; ++i) {
    if (const GLFWvidmode* const mode = glfwGetVideoMode(monitors[i])) rate_hz = std::max(rate_hz, mode->refreshRate);
  }
  const double seconds = 0.95 / std::clamp(rate_hz > 0 ? rate_hz : kUsualRate_hz, 24, 1000);
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

ViewWindow::ViewWindow(std::unique_ptr<State> state) : state_(std::move(state)) {}
ViewWindow::~ViewWindow() = default;
ViewWindow::ViewWindow(ViewWindow&&) noexcept = default;
ViewWindow& ViewWindow::operator=(ViewWindow&&) noexcept = default;

io::Result<ViewWindow> ViewWindow::open(const std::string& title, const WindowOptions& options) {
  if (!glfwInit()) return noWindow("no display to open a window on");
  auto state = std::make_unique<State>();
  GLFWmonitor* const screen = options.screen != 0 ? screenOfNumber(options.screen) : nullptr;
  if (options.screen != 0 && screen == nullptr) {
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("there is no screen {} for --fullscreen: {}", options.screen, screensText()), {});
  }
  state->window = createWindow(title, fitting(options.size), screen);
  if (!state->window) return noWindow("this display gives no window with OpenGL 4.5");
  glfwMakeContextCurrent(state->window);
  glfwSwapInterval(1);
  if (const auto fit = render::checkCurrentContext(); !fit) return tl::unexpected(fit.error());
  state->panels = startPanels(state->window, options.uiScale);
  if (!state->panels) return noWindow("the window's panels cannot be drawn");
  listen(state->window, state->heard);
  state->leastBetweenPictures = leastTimeBetweenPictures();
  return ViewWindow(std::move(state));
}

void ViewWindow::appear() {
  glfwShowWindow(state_->window);
}

void ViewWindow::setTitle(const std::string& title) {
  glfwSetWindowTitle(state_->window, title.c_str());
}

bool ViewWindow::closing() const {
  return glfwWindowShouldClose(state_->window) != 0;
}
void ViewWindow::close() {
  glfwSetWindowShouldClose(state_->window, GLFW_TRUE);
}

scene::Viewport ViewWindow::pictureSize() const {
  if (glfwGetWindowAttrib(state_->window, GLFW_ICONIFIED)) return {0, 0};
  scene::Viewport size;
  glfwGetFramebufferSize(state_->window, &size.width, &size.height);
  return size;
}

std::optional<scene::ViewerMemory::Size> ViewWindow::ordinarySize() const {
  GLFWwindow* const window = state_->window;
  if (glfwGetWindowMonitor(window) != nullptr || glfwGetWindowAttrib(window, GLFW_ICONIFIED) ||
      glfwGetWindowAttrib(window, GLFW_MAXIMIZED))
    return std::nullopt;
  scene::ViewerMemory::Size size;
  glfwGetWindowSize(window, &size.width, &size.height);
  return size;
}

void ViewWindow::closeSoon() {
  close();
  wake();
}

void ViewWindow::wake() {
  glfwPostEmptyEvent();
}

void ViewWindow::wait(std::optional<std::chrono::milliseconds> atMost) {
  if (!atMost) {
    glfwWaitEvents();
  } else if (atMost->count() > 0) {
    glfwWaitEventsTimeout(std::chrono::duration<double>(*atMost).count());
  } else {
    glfwPollEvents();
  }
}

std::vector<InputEvent> ViewWindow::takeEvents() {
  return std::exchange(state_->heard.events, {});
}

void ViewWindow::expectText(bool expected) {
  state_->heard.typing = expected;
}

void ViewWindow::expectMotion(bool expected) {
  Heard& heard = state_->heard;
  if (expected == heard.motion) return;
  heard.motion = expected;
  for (const auto& [key, motion] : kMotion) {
    if (expected && glfwGetKey(state_->window, key) == GLFW_PRESS)
      heard.events.emplace_back(MotionKeyChanged{motion, true});
  }
}

bool ViewWindow::hasTyped() const {
  return ImGui::GetIO().WantTextInput && !state_->heard.typed.empty();
}

void ViewWindow::beginPanels() {
  Heard& heard = state_->heard;
  if (ImGui::GetIO().WantTextInput && !heard.typed.empty()) {
    const Typed typed = heard.typed.front();
    heard.typed.pop_front();
    if (typed.character != 0) ImGui_ImplGlfw_CharCallback(state_->window, typed.character);
    if (typed.character == 0)
      ImGui_ImplGlfw_KeyCallback(state_->window, typed.key, typed.scancode, typed.action, typed.modifiers);
  }
  if (!heard.typing && !ImGui::GetIO().WantTextInput) heard.typed.clear();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void ViewWindow::endPanels() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void ViewWindow::show() {
  glfwSwapBuffers(state_->window);
  std::this_thread::sleep_until(state_->shown + state_->leastBetweenPictures);
  state_->shown = std::chrono::steady_clock::now();
}

void ViewWindow::copyToClipboard(const std::string& text) {
  glfwSetClipboardString(state_->window, text.c_str());
}

}  // namespace tellurion::app

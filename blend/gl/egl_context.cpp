// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/egl_context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

// The first error that the driver reported through debug output on this thread; empty: none.
thread_local std::string reported_error;

void GLAPIENTRY remember_error(GLenum /*source*/, GLenum type, GLuint /*id*/, GLenum /*severity*/, GLsizei /*length*/,
                               const GLchar* message, const void* /*user*/) {
  if (type == GL_DEBUG_TYPE_ERROR && reported_error.empty()) reported_error = message;
}

bool can_be_loaded(const char* library) {
  return dlopen(library, RTLD_LAZY | RTLD_LOCAL) != nullptr;  // and stays: epoxy is going to want it
}

// epoxy ends the program where it finds no library. These are the names that it tries.
void require_libraries() {
  if (!can_be_loaded("libEGL.so.1")) {
    throw GlError("no OpenGL: libEGL.so.1 cannot be loaded: install it (libegl1), or a driver that brings it");
  }
  if (!can_be_loaded("libOpenGL.so.0") && !can_be_loaded("libGL.so.1")) {
    throw GlError("no OpenGL: neither libOpenGL.so.0 nor libGL.so.1 can be loaded: install one (libopengl0, libgl1)");
  }
}

struct Platform {
  std::string name;
  EGLDisplay display;
};

bool has_client_extension(const char* name) {
  return epoxy_has_egl_extension(EGL_NO_DISPLAY, name);
}

// eglGetPlatformDisplayEXT, because epoxy cannot resolve eglGetPlatformDisplay before a display exists.
std::vector<Platform> platforms() {
  std::vector<Platform> found;
  if (has_client_extension("EGL_EXT_device_enumeration") && has_client_extension("EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count)) {
      for (EGLint i = 0; i < count; ++i) {
        found.push_back(
            {"EGL device " + std::to_string(i),
             eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], nullptr)});
      }
    }
  }
  if (has_client_extension("EGL_MESA_platform_surfaceless")) {
    found.push_back(
        {"surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)});
  }
  return found;
}

// Returns whether a context can be told to report a reset of the GPU. Without that, the driver chooses what happens
// then.
bool can_report_resets(EGLDisplay display) {
  return epoxy_egl_version(display) >= 15 || epoxy_has_egl_extension(display, "EGL_EXT_create_context_robustness");
}

struct GlVersion {
  EGLint major, minor;
  bool embedded;  // OpenGL ES
};

EGLenum api_of(bool embedded) {
  return embedded ? EGL_OPENGL_ES_API : EGL_OPENGL_API;
}

// A core context of that version or a later one, which may share its objects with another. The API must be bound.
EGLContext make_context(EGLDisplay display, EGLConfig config, const GlVersion& version, bool debug,
                        EGLContext shared = EGL_NO_CONTEXT) {
  std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION, version.major,
                                 EGL_CONTEXT_MINOR_VERSION, version.minor,
                                 EGL_CONTEXT_OPENGL_DEBUG,  debug ? EGL_TRUE : EGL_FALSE};
  if (!version.embedded) {
    attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT});
  }
  const std::size_t plain = attributes.size();
  if (can_report_resets(display)) {
    attributes.insert(attributes.end(),
                      {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET, EGL_NONE});
    auto* const made = eglCreateContext(display, config, shared, attributes.data());
    if (made != EGL_NO_CONTEXT) return made;
    attributes.resize(plain);
  }
  attributes.push_back(EGL_NONE);
  return eglCreateContext(display, config, shared, attributes.data());
}

// Returns the configuration of a context, which may be none.
EGLConfig config_of(EGLDisplay display, EGLContext context) {
  EGLint number = 0, configs = 0;
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!eglQueryContext(display, context, EGL_CONFIG_ID, &number) || number == 0) return EGL_NO_CONFIG_KHR;
  const std::array<EGLint, 3> attributes{EGL_CONFIG_ID, number, EGL_NONE};
  if (!eglChooseConfig(display, attributes.data(), &config, 1, &configs) || configs == 0) return EGL_NO_CONFIG_KHR;
  return config;
}

// For people whose driver is too old: which version it has.
std::string newest_version(EGLDisplay display, EGLConfig config) {
  constexpr std::array<std::array<EGLint, 2>, 8> kVersions{
      {{4, 4}, {4, 3}, {4, 2}, {4, 1}, {4, 0}, {3, 3}, {3, 2}, {3, 1}}};
  for (const auto& [major, minor] : kVersions) {
    auto* const made = make_context(display, config, {major, minor, false}, false);
    if (made == EGL_NO_CONTEXT) continue;
    eglDestroyContext(display, made);
    return "only OpenGL " + std::to_string(major) + "." + std::to_string(minor);
  }
  return "no OpenGL core context";
}

std::string gl_string(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text ? reinterpret_cast<const char*>(text) : "unknown";
}

// The binding of a thread's current context, made by any code.
struct Binding {
  EGLenum api = eglQueryAPI();
  EGLDisplay display = eglGetCurrentDisplay();
  EGLSurface draw = eglGetCurrentSurface(EGL_DRAW);
  EGLSurface read = eglGetCurrentSurface(EGL_READ);
  EGLContext context = eglGetCurrentContext();
};

// `display` is the one of the context that is current now.
void bind_again(const Binding& binding, EGLDisplay display) {
  if (binding.context == EGL_NO_CONTEXT) {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  } else {
    eglMakeCurrent(binding.display, binding.draw, binding.read, binding.context);
  }
  eglBindAPI(binding.api);
}

void require_whole(bool has_state) {
  if (!has_state) throw std::invalid_argument("EglContext: context has been moved from, must be one that was not");
}

}  // namespace

struct EglContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  bool embedded = false;
  std::string description;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (context == EGL_NO_CONTEXT) return;
    if (eglGetCurrentContext() == context) {
      eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    eglDestroyContext(display, context);
    // The display is shared by every context of the process and is not terminated.
  }

  // The empty string, or why this display does not do.
  std::string open(const Platform& platform, const Options& options) {
    EGLint major = 0;
    EGLint minor = 0;
    if (platform.display == EGL_NO_DISPLAY || !eglInitialize(platform.display, &major, &minor)) return "no display";
    embedded = options.embedded;
    if (!eglBindAPI(api_of(embedded))) return embedded ? "no OpenGL ES" : "no desktop OpenGL";
    if (!epoxy_has_egl_extension(platform.display, "EGL_KHR_surfaceless_context")) return "no surfaceless contexts";
    const std::array<EGLint, 3> config_attributes{EGL_RENDERABLE_TYPE, embedded ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT,
                                                  EGL_NONE};
    EGLConfig config = nullptr;
    EGLint configs = 0;
    if (!eglChooseConfig(platform.display, config_attributes.data(), &config, 1, &configs) || configs == 0) {
      config = EGL_NO_CONFIG_KHR;
    }
    const GlVersion version = embedded ? GlVersion{3, 0, true} : GlVersion{4, 5, false};
    EGLContext made = make_context(platform.display, config, version, options.debug);
    if (made == EGL_NO_CONTEXT) return embedded ? "no OpenGL ES 3.0" : newest_version(platform.display, config);
    if (!eglMakeCurrent(platform.display, EGL_NO_SURFACE, EGL_NO_SURFACE, made)) {
      eglDestroyContext(platform.display, made);
      return "the context cannot be made current";
    }
    display = platform.display;
    context = made;
    description =
        platform.name + ": " + gl_string(GL_RENDERER) + (embedded ? ", " : ", OpenGL ") + gl_string(GL_VERSION);
    return {};
  }
};

EglContext::EglContext(const Options& options) : state_(std::make_unique<State>()) {
  require_libraries();
  const Binding previous;
  std::string tried;
  for (const Platform& platform : platforms()) {
    const std::string reason = state_->open(platform, options);
    if (reason.empty()) break;
    tried += (tried.empty() ? "" : "; ") + platform.name + ": " + reason;
  }
  if (state_->context == EGL_NO_CONTEXT) {
    throw GlError("no OpenGL " + std::string(options.embedded ? "ES 3.0" : "4.5") + " through EGL (" +
                  (tried.empty() ? "no EGL platform" : tried) +
                  "): install a newer driver, or Mesa's software renderer (libegl1, libgl1-mesa-dri)");
  }
  reported_error.clear();
  if (options.debug) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(remember_error, nullptr);
  }
  if (!options.stays_current) bind_again(previous, state_->display);
}

EglContext::EglContext(std::unique_ptr<State> state) : state_(std::move(state)) {}

std::optional<EglContext> EglContext::sharing_with_current() {
  if (!can_be_loaded("libEGL.so.1")) return std::nullopt;
  const Binding current;
  if (current.context == EGL_NO_CONTEXT) return std::nullopt;
  if (!epoxy_has_egl_extension(current.display, "EGL_KHR_surfaceless_context")) return std::nullopt;
  auto state = std::make_unique<State>();
  state->display = current.display;
  state->embedded = !epoxy_is_desktop_gl();
  GLint major = 0, minor = 0;
  glGetIntegerv(GL_MAJOR_VERSION, &major);
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  eglBindAPI(api_of(state->embedded));
  state->context = make_context(current.display, config_of(current.display, current.context),
                                {major, minor, state->embedded}, false, current.context);
  eglBindAPI(current.api);
  if (state->context == EGL_NO_CONTEXT) return std::nullopt;
  state->description = "sharing: " + gl_string(GL_RENDERER);
  return EglContext(std::move(state));
}

EglContext::~EglContext() = default;
EglContext::EglContext(EglContext&&) noexcept = default;
EglContext& EglContext::operator=(EglContext&&) noexcept = default;

const std::string& EglContext::description() const {
  require_whole(state_ != nullptr);
  return state_->description;
}

struct CurrentContext::Previous {
  Binding binding;
  EGLDisplay display;  // display of the context that is current meanwhile
};

CurrentContext::CurrentContext(const EglContext& context) {
  require_whole(context.state_ != nullptr);
  previous_ = std::make_unique<Previous>(Previous{{}, context.state_->display});
  const EglContext::State& state = *context.state_;
  eglBindAPI(api_of(state.embedded));  // each thread begins with OpenGL ES
  if (eglMakeCurrent(state.display, EGL_NO_SURFACE, EGL_NO_SURFACE, state.context)) return;
  const bool lost = eglGetError() == EGL_CONTEXT_LOST;
  eglBindAPI(previous_->binding.api);
  if (lost) throw GlError(gl_error_sentence(GL_CONTEXT_LOST, "making its context current"));
  throw GlError("the OpenGL context cannot be made current: another thread has it");
}

CurrentContext::~CurrentContext() {
  bind_again(previous_->binding, previous_->display);
}

void check_gl(const char* doing) {
  if (!doing) throw std::invalid_argument("check_gl: doing is null, must say what was done");
  const GLenum code = glGetError();
  if (!reported_error.empty()) {
    throw GlError("OpenGL failed while " + std::string(doing) + ": " + std::exchange(reported_error, {}));
  }
  if (code != GL_NO_ERROR) throw GlError(gl_error_sentence(code, doing));
}

std::string gl_error_sentence(unsigned int code, const char* doing) {
  if (code == GL_CONTEXT_LOST) {
    return "the GPU was reset while " + std::string(doing) +
           ", and all that was on it is lost: run this again, with smaller pictures or fewer references if that "
           "happens "
           "more than once";
  }
  if (code == GL_OUT_OF_MEMORY) {
    return "OpenGL ran out of memory while " + std::string(doing) +
           ": use fewer views, smaller photographs or a coarser mesh";
  }
  return "OpenGL failed while " + std::string(doing) + ": error " + std::to_string(code);
}

}  // namespace lumatlas

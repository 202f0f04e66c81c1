// SPDX-License-Identifier: GPL-3.0-or-later
// A headless context through EGL: OpenGL 4.5 core, or OpenGL ES 3.0.
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace lumatlas {

// A failure of EGL, GL or its driver. what() is one sentence.
class GlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Tries every EGL device in turn, then Mesa's surfaceless platform, and takes the first that gives such a context.
// The context is current on the thread that made it, from construction to destruction; one at a time per thread.
// Only a context that does not stay current may be used, and destroyed, on other threads: see CurrentContext.
class EglContext {
 public:
  struct Options {
    bool debug = false;  // GL debug output on: an error reported by the driver becomes a GlError, see check_gl()
    // Off: whatever was current on this thread before is so again once the context is made.
    bool stays_current = true;
    // OpenGL ES 3.0, or a later one that is compatible with it: what a browser's WebGL 2 has.
    bool embedded = false;
  };
  explicit EglContext(const Options& options);  // throws GlError: what is missing, or was tried and why it failed
  EglContext() : EglContext(Options{}) {}
  // Returns a context that shares its textures, buffers and programs with the context that is current on this thread,
  // which any code may have made. It is current on no thread: see CurrentContext. None if no context of EGL is current,
  // or if its driver makes no second one.
  [[nodiscard]] static std::optional<EglContext> sharing_with_current();
  ~EglContext();
  EglContext(EglContext&&) noexcept;
  EglContext& operator=(EglContext&&) noexcept;

  // Here and in CurrentContext, std::invalid_argument for a context that has been moved from.
  [[nodiscard]] const std::string& description() const;  // platform, renderer and version: "device 0: llvmpipe (...)"

 private:
  friend class CurrentContext;
  struct State;
  explicit EglContext(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Makes a context current on this thread for as long as it lives; then whatever was current before is so again.
class CurrentContext {
 public:
  explicit CurrentContext(const EglContext& context);  // throws GlError if the context is current on another thread
  ~CurrentContext();
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  struct Previous;
  std::unique_ptr<const Previous> previous_;
};

// Throws GlError with the driver's own message if GL has reported an error since the last call; `doing` says when, and
// is not null (std::invalid_argument).
void check_gl(const char* doing);

// Returns the sentence of check_gl() for an error code of glGetError() other than GL_NO_ERROR.
[[nodiscard]] std::string gl_error_sentence(unsigned int code, const char* doing);

}  // namespace lumatlas

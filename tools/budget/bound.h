// SPDX-License-Identifier: GPL-3.0-or-later
// The bound of a model beside the number of its views: bytes on the GPU, or the loss against all photographs.
#pragma once

#include <cstdint>

namespace lumatlas {

// One bound or none, never two.
class Bound {
 public:
  Bound() = default;  // none: the number and the bytes of the views bound the model

  // The texture array of tiles takes at most this. 0: no bound.
  [[nodiscard]] static Bound of_array(std::uint64_t bytes);
  // The model takes at most this on the GPU, mesh and tables included: see gpu_budget.h. 0: no bound.
  [[nodiscard]] static Bound of_gpu(std::uint64_t bytes);
  // Downscaled and compressed texels may lose `texels_db`, and faces with them `faces_db`, both dB by measurement. Each
  // may be 0: nothing of the kind is given up.
  [[nodiscard]] static Bound of_loss(double texels_db, double faces_db);

  // Each returns 0 where something else bounds the model.
  [[nodiscard]] std::uint64_t array_bytes() const { return kind_ == Kind::array ? bytes_ : 0; }
  [[nodiscard]] std::uint64_t gpu_bytes() const { return kind_ == Kind::gpu ? bytes_ : 0; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  // of the array or of the GPU
  [[nodiscard]] double texel_loss_db() const { return texel_loss_db_; }
  [[nodiscard]] double face_loss_db() const { return face_loss_db_; }

 private:
  enum class Kind { none, array, gpu, loss };

  Kind kind_ = Kind::none;
  std::uint64_t bytes_ = 0;
  double texel_loss_db_ = 0, face_loss_db_ = 0;
};

// Throws std::invalid_argument, naming the loss and its value, unless both are finite and not negative.
void check(const Bound& bound);

}  // namespace lumatlas

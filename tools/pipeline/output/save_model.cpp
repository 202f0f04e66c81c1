// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/output/save_model.h"

#include <utility>

#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/worth_saving.h"

namespace lumatlas {

using nlohmann::json;

json save_model(const BuildResult& result, ModelOutput& output, const ImageCoding& photographs, std::size_t unplaced) {
  require_worth_saving(result, unplaced, output.target());
  json totals = summary(result, result.options);
  json plan = plan_json(result);
  plan["summary"] = totals;
  json effective = effective_options(result, result.options);
  effective["image"] = ending(photographs.format) + 1;
  effective["quality"] = photographs.format == ImageFormat::png ? json() : json(photographs.quality);
  output.commit(result.snapshot, result.effective.validity, photographs, {std::move(effective), std::move(plan)},
                result.texture ? &result.texture->texture : nullptr);
  return totals;
}

json save_model(const BuildResult& result, const std::filesystem::path& path, const ImageCoding& photographs) {
  ModelOutput output(path);
  return save_model(result, output, photographs);
}

}  // namespace lumatlas

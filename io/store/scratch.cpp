#include "io/store/scratch.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"

namespace tetfusion {

std::unique_ptr<PieceStore> Checkpoint::take_kept(const std::string& name, const char* what) {
  const auto store = kept.find(name);
  if (store == kept.end() || store->second == nullptr) {
    throw Error(ErrorCode::kIo,
                fmt::format("the work in the scratch folder lacks {}: remove the folder, and start "
                            "the run again",
                            what));
  }
  return std::move(store->second);
}

}  // namespace tetfusion

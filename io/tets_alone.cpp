#include "io/tets_alone.h"

#include <utility>

#include "io/stream_around.h"

namespace tetfusion {

namespace {

class TetsAlone final : public StreamAround {
 public:
  using StreamAround::StreamAround;

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    StreamAround::read_cells(first, count, out);
    out->lower = {};
    out->lower_rows.clear();
  }
};

}  // namespace

std::unique_ptr<MeshStream> tets_alone(std::unique_ptr<MeshStream> stream) {
  return std::make_unique<TetsAlone>(std::move(stream));
}

}  // namespace tetfusion

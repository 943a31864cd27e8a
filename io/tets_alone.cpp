#include "io/tets_alone.h"

#include <utility>

namespace tetfusion {

namespace {

class TetsAlone : public MeshStream {
 public:
  explicit TetsAlone(std::unique_ptr<MeshStream> all) : all_(std::move(all)) {}

  std::uint64_t points() const override { return all_->points(); }
  std::uint64_t cells() const override { return all_->cells(); }
  std::uint64_t ghost_cells() const override { return all_->ghost_cells(); }
  std::uint64_t merged_points() const override { return all_->merged_points(); }
  std::uint64_t differing_points() const override { return all_->differing_points(); }
  std::uint64_t dropped_points() const override { return all_->dropped_points(); }
  bool streams_from_disk() const override { return all_->streams_from_disk(); }
  std::uint64_t bytes() const override { return all_->bytes(); }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    all_->read_points(first, count, out);
  }
  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    all_->read_cells(first, count, out);
    out->lower = {};
    out->lower_rows.clear();
  }
  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    all_->read_rows(association, index, first, count, out);
  }
  void read_locks(std::uint64_t first, std::uint64_t count, std::uint8_t* locked) const override {
    all_->read_locks(first, count, locked);
  }

 private:
  std::unique_ptr<MeshStream> all_;
};

}  // namespace

std::unique_ptr<MeshStream> tets_alone(std::unique_ptr<MeshStream> stream) {
  return std::make_unique<TetsAlone>(std::move(stream));
}

}  // namespace tetfusion

// A stream over another one, for those that change a part of what it gives.
#pragma once

#include <memory>
#include <utility>

#include "io/source/mesh_stream.h"

namespace tetfusion {

// Gives all that the inner stream gives.
class StreamAround : public MeshStream {
 public:
  explicit StreamAround(std::unique_ptr<MeshStream> inner) : inner_(std::move(inner)) {}

  std::uint64_t points() const override { return inner_->points(); }
  std::uint64_t cells() const override { return inner_->cells(); }
  LowerCount lower_cells() const override { return inner_->lower_cells(); }
  std::uint64_t ghost_cells() const override { return inner_->ghost_cells(); }
  std::uint64_t merged_points() const override { return inner_->merged_points(); }
  std::uint64_t differing_points() const override { return inner_->differing_points(); }
  LargestDifference largest_difference() const override { return inner_->largest_difference(); }
  std::uint64_t dropped_points() const override { return inner_->dropped_points(); }
  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    inner_->read_points(first, count, out);
  }
  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    inner_->read_cells(first, count, out);
  }
  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    inner_->read_rows(association, index, first, count, out);
  }
  void read_locks(std::uint64_t first, std::uint64_t count, std::uint8_t* locked) const override {
    inner_->read_locks(first, count, locked);
  }
  bool streams_from_disk() const override { return inner_->streams_from_disk(); }
  std::uint64_t bytes() const override { return inner_->bytes(); }

 protected:
  const MeshStream& inner() const { return *inner_; }

 private:
  std::unique_ptr<MeshStream> inner_;
};

}  // namespace tetfusion

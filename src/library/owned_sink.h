// A sink that keeps the mesh in memory of the public header's kind.
#pragma once

#include "io/source/mesh_sink.h"
#include "tetfusion.h"

namespace tetfusion {

class OwnedSink final : public MeshSink {
 public:
  // The type of the connectivity, and whether there are offsets and types, are those of the input;
  // but 64 bits where the offsets need them.
  // Active markers and the like do not come here.
  explicit OwnedSink(const Mesh& input)
      : id_type_(input.connectivity.type()), tets_only_(input.types.empty()) {}

  MeshRoom make_room(const MeshLayout& layout) override;
  OwnedMesh take() { return std::move(mesh_); }

 private:
  Type id_type_;
  bool tets_only_;
  OwnedMesh mesh_;
};

}  // namespace tetfusion

#include "driver/fingerprint.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <cstddef>
#include <fstream>
#include <span>

#include "base/version.h"
#include "driver/checkpoint.h"
#include "io/files/checksum.h"

namespace tetfusion {

namespace {

std::string join(const std::vector<double>& values) {
  std::string text;
  for (const double v : values) text += fmt::format("{} ", v);
  return text;
}
std::string join(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& v : values) text += fmt::format("\"{}\" ", v);
  return text;
}

// Of blocks at even distances, the first and the last among them. Reading all of a file of many
// gigabytes would cost as much as the run.
std::uint64_t sample_hash(const std::string& path, std::uint64_t bytes) {
  constexpr std::uint64_t kBlocks = 64;
  constexpr std::size_t kBlockBytes = 4096;
  std::ifstream file(path, std::ios::binary);
  std::uint64_t hash = 0;
  std::array<std::byte, kBlockBytes> block{};
  for (std::uint64_t i = 0; i < kBlocks; ++i) {
    const std::uint64_t last = bytes > kBlockBytes ? bytes - kBlockBytes : 0;
    file.clear();
    file.seekg(static_cast<std::streamoff>(last / (kBlocks - 1) * i +
                                           last % (kBlocks - 1) * i / (kBlocks - 1)));
    file.read(reinterpret_cast<char*>(block.data()), kBlockBytes);
    hash = checksum({block.data(), static_cast<std::size_t>(file.gcount())}, hash);
  }
  return hash;
}

// Their sizes and times, and samples of what is in them.
std::uint64_t hash_of(const std::vector<std::string>& files) {
  std::string text;
  for (const std::string& path : files) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) continue;
    const auto bytes = static_cast<std::uint64_t>(status.st_size);
    text += fmt::format("{} {} {}.{} {:x}\n", path, bytes, status.st_mtim.tv_sec,
                        status.st_mtim.tv_nsec, sample_hash(path, bytes));
  }
  return checksum(std::as_bytes(std::span(text)));
}

}  // namespace

std::string fingerprint(const SimplifyRequest& request, const MeshDescription& mesh) {
  const BehaviourOptions& b = request.behaviour;
  // A new option does not compile here until it is looked at below, but for the time step, which
  // the description has.
  [[maybe_unused]] const auto& [method, boundary_rule, reduction, tets, scalar_tolerance,
                                stretch_factor, aspect_ratio, max_volume, min_quality, max_rms,
                                give_up_rms, max_error, conserve, boundary, boundary_distance,
                                feature_angle, arrays, regions, interest, fit_values, weight, lods,
                                chunk_tets, original_ids, tetrahedralize, linearize, merge_points,
                                drop_patches, dropped_patches, time_step] = b;
  std::string text = fmt::format("program: tetfusion {}, state {}\n", version(), kStateFormat);
  text += fmt::format("method: {}\nminimum quality: {}\nmaximum rms: {}\n",
                      static_cast<int>(b.method), b.min_quality.value_or(kDefaultMinQuality),
                      b.max_rms ? fmt::format("{}", *b.max_rms) : "none");
  text += fmt::format("give up: {}\n", b.give_up_rms.value_or(0));
  text += fmt::format("conserve: {}\nfit values: {}\n", b.conserve, b.fit_values);
  text += fmt::format("boundary: {} {}\nfeature angle: {}\n", static_cast<int>(b.boundary),
                      b.boundary_distance, b.feature_angle.value_or(kFeatureAngle));
  text +=
      fmt::format("maximum error: {}\n", b.max_error ? fmt::format("{}", *b.max_error) : "none");
  text += fmt::format("boundary rule: {}\n", static_cast<int>(b.boundary_rule));
  text += fmt::format("reduction: {}\n", b.reduction ? fmt::format("{}", *b.reduction) : "none");
  text += fmt::format("tets: {}\n", b.tets ? fmt::format("{}", *b.tets) : "none");
  text += fmt::format("scalar tolerance: {}\n", join(b.scalar_tolerance));
  text += fmt::format("stretch factor: {}\n", join(b.stretch_factor));
  text += fmt::format("aspect ratio: {}\n", b.aspect_ratio);
  text += fmt::format("maximum volume: {}\n", b.max_volume);
  text += fmt::format("arrays: {}\n", join(b.arrays));
  text += fmt::format("regions: {}\n", b.regions ? join(*b.regions) : "default");
  text += fmt::format("region of interest: {}\n", join(b.interest));
  text += fmt::format("weight: {}\n", b.weight);
  text += fmt::format("lods: {}\n", join(b.lods));
  text += fmt::format("chunk tets: {}\n", b.chunk_tets);
  text += fmt::format("original ids: {}\n", b.original_ids);
  text += fmt::format("tetrahedralize: {}\nlinearize: {}\n", b.tetrahedralize, b.linearize);
  text += fmt::format("merge points: {}\ndrop patches: {} {}\n", b.merge_points, b.drop_patches,
                      join(b.dropped_patches));
  text +=
      fmt::format("output: {}\nencoding: {}\n", request.output, static_cast<int>(request.encoding));
  text += fmt::format("pieces: {}\n", request.pieces);
  text += fmt::format("progressive: {}\n", request.progressive);
  text += fmt::format("map: {}\n", !request.map.empty());
  text += fmt::format("input: {}\ninput bytes: {}\n", mesh.path, mesh.file_bytes);
  text += fmt::format("time step: {}\n", mesh.time_step);
  struct stat status {};
  if (mesh.spooled_checksum) {
    text += fmt::format("input checksum: {:016x}\n", *mesh.spooled_checksum);
  } else if (::stat(mesh.path.c_str(), &status) == 0) {
    text +=
        fmt::format("input changed at: {}.{:09}\n", status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
    text += fmt::format("input samples: {:016x}\n", sample_hash(mesh.path, mesh.file_bytes));
  }
  if (!mesh.files.empty()) text += fmt::format("input pieces: {:016x}\n", hash_of(mesh.files));
  return text;
}

}  // namespace tetfusion

// Without a fuzzer: each target takes its seeds, and the cases that a folder keeps for it.
//
//   fuzz_replay CASES               CASES/TARGET/* are the cases
//   fuzz_replay --write-seeds DIR   writes DIR/TARGET/NUMBER: what a fuzzer begins with
//   fuzz_replay --read TARGET FILE...
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz/targets.h"

namespace {

using tetfusion::fuzz::Target;
namespace fs = std::filesystem;

bool holds(const Target& target, const std::string& name, const std::string& bytes) try {
  target.run({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  return true;
} catch (const std::exception& e) {
  std::printf("%s, %s: %s\n", std::string(target.name).c_str(), name.c_str(), e.what());
  return false;
}

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(folder))
    files.assign(fs::directory_iterator(folder), fs::directory_iterator());
  std::sort(files.begin(), files.end());
  return files;
}

bool replay(const Target& target, const fs::path& folder) {
  const std::vector<std::string> seeds = target.seeds();
  bool good = true;
  for (std::size_t i = 0; i < seeds.size(); ++i)
    good &= holds(target, "seed " + std::to_string(i), seeds[i]);
  const std::vector<fs::path> cases = files_in(folder / target.name);
  for (const fs::path& file : cases) good &= holds(target, file.string(), content(file));
  std::printf("%s: %zu seeds, %zu cases\n", std::string(target.name).c_str(), seeds.size(),
              cases.size());
  return good;
}

void write_seeds(const Target& target, const fs::path& folder) {
  fs::create_directories(folder / target.name);
  const std::vector<std::string> seeds = target.seeds();
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    std::ofstream(folder / target.name / std::to_string(i), std::ios::binary) << seeds[i];
  }
}

int usage() {
  std::fputs("usage: fuzz_replay CASES | --write-seeds DIR | --read TARGET FILE...\n", stderr);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  bool good = true;
  if (arguments.size() > 2 && arguments[0] == "--read") {
    const Target* const target = tetfusion::fuzz::find_target(arguments[1]);
    if (target == nullptr) return usage();
    for (std::size_t i = 2; i < arguments.size(); ++i)
      good &= holds(*target, arguments[i], content(arguments[i]));
    return good ? 0 : 1;
  }
  const bool write = arguments.size() == 2 && arguments[0] == "--write-seeds";
  if (!write && arguments.size() != 1) return usage();
  for (const Target& target : tetfusion::fuzz::targets()) {
    if (write) {
      write_seeds(target, arguments[1]);
    } else {
      good &= replay(target, arguments[0]);
    }
  }
  return good ? 0 : 1;
}

#include "io/vtk/pieces_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>

#include "base/error.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::FaultyFileSystem;
using ::testing::HasSubstr;
using testing::TempDir;
namespace fs = std::filesystem;

class Pieces : public ::testing::Test {
 protected:
  static void write(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  std::set<std::string> names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(dir.path())) {
      names.insert(fs::relative(entry.path(), dir.path()).string());
    }
    return names;
  }
  void write_pieces(std::uint32_t count, const std::string& text = "piece") {
    PiecesOutput output(path);
    for (std::uint32_t i = 0; i < count; ++i) {
      OutputFile file(output.piece_path(i));
      file.append(text.data(), text.size());
      file.commit();
    }
    output.commit(layout, count);
  }
  ErrorCode refusal() const {
    try {
      check_pieces_output(path);
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr(path));
      return e.code();
    }
    ADD_FAILURE() << "was not refused";
    return {};
  }

  TempDir dir = TempDir::in_memory();
  std::string path = dir.file("a.pvtu");
  VtuLayout layout;
};

TEST_F(Pieces, AreNamedByTheFile) {
  path = dir.file("a & b.PVTU");
  EXPECT_TRUE(is_pieces_name(path));
  EXPECT_FALSE(is_pieces_name(dir.file("pvtu")));
  layout.point_type = ValueType::kFloat64;
  layout.point_data.arrays = {{"p", ValueType::kFloat32, 2, {"x", "y"}, 0},
                              {"GlobalNodeIds", ValueType::kInt64, 1, {}, 0}};
  layout.point_data.arrays[0].units = "m & s";
  layout.point_data.active = {{"GlobalIds", "GlobalNodeIds"}};
  write_pieces(2);
  const std::string text = bytes_of(path);
  EXPECT_THAT(text, HasSubstr("<VTKFile type=\"PUnstructuredGrid\""));
  EXPECT_THAT(text, HasSubstr("<PPointData GlobalIds=\"GlobalNodeIds\">"));
  EXPECT_THAT(text, HasSubstr("<PDataArray type=\"Float32\" Name=\"p\" NumberOfComponents=\"2\" "
                              "ComponentName0=\"x\" ComponentName1=\"y\"><InformationKey "
                              "name=\"UNITS_LABEL\" location=\"vtkDataArray\">m &amp; "
                              "s</InformationKey></PDataArray>"));
  EXPECT_THAT(text, HasSubstr("<PDataArray type=\"Int64\" Name=\"GlobalNodeIds\"/>"));
  EXPECT_THAT(text,
              HasSubstr("<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>"));
  EXPECT_THAT(text, HasSubstr("<Piece Source=\"a &amp; b_pieces/a &amp; b_1.vtu\"/>"));
  EXPECT_EQ(names(),
            (std::set<std::string>{"a & b.PVTU", "a & b_pieces", "a & b_pieces/a & b_0.vtu",
                                   "a & b_pieces/a & b_1.vtu"}));
}

TEST_F(Pieces, ReplaceThoseOfTheOldFile) {
  write_pieces(3);
  write_pieces(1, "new");
  const std::set<std::string> second{"a.pvtu", "a_pieces-2", "a_pieces-2/a_0.vtu"};
  EXPECT_EQ(names(), second);
  EXPECT_EQ(bytes_of(dir.file("a_pieces-2/a_0.vtu")), "new");
  write_pieces(1);
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces", "a_pieces/a_0.vtu"}));
  fs::remove_all(dir.file("a_pieces"));  // the old file names a folder that is not there
  write_pieces(1);
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces", "a_pieces/a_0.vtu"}));
}

TEST_F(Pieces, TouchNothingElse) {
  fs::create_directory(dir.file("a_pieces"));
  write(dir.file("a_pieces/a_0.vtu"), "somebody's");
  write_pieces(1);
  write(dir.file("a_pieces-2/note"), "somebody's");
  write(dir.file("a_pieces-2/a_x.vtu"), "somebody's");
  write_pieces(1);
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces", "a_pieces/a_0.vtu", "a_pieces-2",
                                            "a_pieces-2/a_x.vtu", "a_pieces-2/note", "a_pieces-3",
                                            "a_pieces-3/a_0.vtu"}));
  // A file of another program.
  fs::create_directory(dir.file("b"));
  write(dir.file("b/a_0.vtu"), "somebody's");
  for (const char* source :
       {"b/a_0.vtu", "../a_pieces/a_0.vtu", "a_pieces../a_0.vtu", "", "a_pieces"}) {
    write(path, std::string("<Piece Source=\"") + source + "\"/>");
    write_pieces(1);
    EXPECT_EQ(bytes_of(dir.file("b/a_0.vtu")), "somebody's");
  }
}

TEST_F(Pieces, RefuseWhatCannotBeWritten) {
  fs::create_symlink("b.pvtu", path);
  EXPECT_EQ(refusal(), ErrorCode::kUsage);
  path = dir.file("out\xff.pvtu");  // the index names its pieces, in UTF-8
  EXPECT_EQ(refusal(), ErrorCode::kUsage);
  path = dir.file(std::string(245, 'x') + ".pvtu");
  EXPECT_EQ(refusal(), ErrorCode::kIo);
  path = dir.file("missing/a.pvtu");
  EXPECT_EQ(refusal(), ErrorCode::kIo);
  fs::create_directory(dir.file("a.pvtu.pvtu"));
  path = dir.file("a.pvtu.pvtu");
  EXPECT_EQ(refusal(), ErrorCode::kIo);
}

// Whatever goes wrong: the file names pieces that are all there, old ones or new ones.
TEST_F(Pieces, EveryCallFailsInTurn) {
  int failures = 0;
  for (std::int64_t n = 0;; ++n) {
    for (const bool killed : {false, true}) {
      fs::remove_all(dir.path());
      fs::create_directory(dir.path());
      write_pieces(2, "old");
      bool failed = false, struck = false;
      {
        FaultyFileSystem system;
        if (killed) {
          system.die(n);
        } else {
          system.fail(n, EIO);
        }
        try {
          write_pieces(2, "new");
        } catch (const Error&) {
          failed = true;
        }
        struck = system.struck();
      }
      if (!struck) {
        EXPECT_GT(failures, 20);
        return;
      }
      failures += failed ? 1 : 0;
      const std::string text = bytes_of(path);
      const bool is_new = text.find("a_pieces-2/") != std::string::npos;
      const std::string folder = is_new ? "a_pieces-2" : "a_pieces";
      for (const char* name : {"/a_0.vtu", "/a_1.vtu"}) {
        ASSERT_EQ(bytes_of(dir.file(folder + name)), is_new ? "new" : "old") << n;
      }
      EXPECT_EQ(is_new, !failed) << n;
      if (!killed) continue;
      // What was left the next run takes away, but for a folder that has nothing in it yet.
      write_pieces(1, "last");
      // Nor are temporary names the business of pieces.
      std::set<std::string> left = names();
      std::erase_if(left, [](const std::string& name) { return is_temporary_name(name); });
      for (const char* name : {"a_pieces", "a_pieces-2", "a_pieces-3"}) {
        if (fs::exists(dir.file(name)) && fs::is_empty(dir.file(name))) left.erase(name);
      }
      EXPECT_EQ(left.size(), 3u) << n << " " << ::testing::PrintToString(left);
    }
  }
}

// A process that is killed while it writes: its folder is there, marked.
class DeadPieces : public Pieces {
 protected:
  // Leaves `count` pieces and the marker.
  void die_after(std::uint32_t count) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      PiecesOutput output(path);
      for (std::uint32_t i = 0; i < count; ++i) write(output.piece_path(i), "half a piece");
      ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
};

TEST_F(DeadPieces, GoWithTheNextRun) {
  const std::set<std::string> one{"a.pvtu", "a_pieces", "a_pieces/a_0.vtu"};
  die_after(2);
  EXPECT_EQ(names(), (std::set<std::string>{"a_pieces", "a_pieces/.unfinished", "a_pieces/a_0.vtu",
                                            "a_pieces/a_1.vtu"}));
  write_pieces(1);
  EXPECT_EQ(names(), one);
  die_after(3);  // beside the file's own
  EXPECT_TRUE(fs::exists(dir.file("a_pieces-2/a_2.vtu")));
  EXPECT_EQ(bytes_of(dir.file("a_pieces/a_0.vtu")), "piece");
  write_pieces(1, "new");
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces-2", "a_pieces-2/a_0.vtu"}));
  die_after(1);
  remove_dead_pieces(path);
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces-2", "a_pieces-2/a_0.vtu"}));
  EXPECT_EQ(bytes_of(dir.file("a_pieces-2/a_0.vtu")), "new");
}

TEST_F(DeadPieces, AreNotThoseOfALivingProcess) {
  PiecesOutput output(path);
  write(output.piece_path(0), "in work");
  remove_dead_pieces(path);
  write_pieces(1);
  EXPECT_EQ(names(),
            (std::set<std::string>{"a.pvtu", "a_pieces", "a_pieces/.unfinished", "a_pieces/a_0.vtu",
                                   "a_pieces-2", "a_pieces-2/a_0.vtu"}));
  output.commit(layout, 1);
  EXPECT_EQ(bytes_of(dir.file("a_pieces/a_0.vtu")), "in work");
  EXPECT_FALSE(fs::exists(dir.file("a_pieces/.unfinished")));
}

// Where it is not known what the file names, nothing goes.
TEST_F(DeadPieces, StayWhereTheFileCannotBeRead) {
  write_pieces(1);
  write(dir.file("a_pieces/.unfinished"), "");
  for (const auto call : {FaultyFileSystem::Call::kOpen, FaultyFileSystem::Call::kStat,
                          FaultyFileSystem::Call::kMap}) {
    FaultyFileSystem system;
    system.fail_all(call, EIO);
    remove_dead_pieces(path);
    EXPECT_TRUE(system.struck());
  }
  EXPECT_EQ(bytes_of(dir.file("a_pieces/a_0.vtu")), "piece");
}

TEST_F(DeadPieces, LeaveWhatIsSomebodyElses) {
  die_after(1);
  write(dir.file("a_pieces/note"), "somebody's");
  fs::create_directory(dir.file("a_pieces-2"));  // without a marker
  write(dir.file("a_pieces-2/a_0.vtu"), "somebody's");
  fs::create_directory(dir.file("b_pieces"));  // of another output
  write(dir.file("b_pieces/b_0.vtu"), "somebody's");
  write(dir.file("b_pieces/.unfinished"), "");
  remove_dead_pieces(path);
  EXPECT_EQ(names(),
            (std::set<std::string>{"a_pieces", "a_pieces/note", "a_pieces-2", "a_pieces-2/a_0.vtu",
                                   "b_pieces", "b_pieces/.unfinished", "b_pieces/b_0.vtu"}));
}

// Killed between the name of the file and the end of the marker.
TEST_F(DeadPieces, AreNotThoseThatTheFileNames) {
  write_pieces(2);
  write(dir.file("a_pieces/.unfinished"), "");
  remove_dead_pieces(path);
  EXPECT_EQ(bytes_of(dir.file("a_pieces/a_1.vtu")), "piece");
  write_pieces(1);
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces-2", "a_pieces-2/a_0.vtu"}));
}

TEST_F(DeadPieces, LeaveNoMarkerInTheOldOnesWhereTheFileCannotBeWritten) {
  write_pieces(1);
  {
    FaultyFileSystem system;
    system.fail_all(FaultyFileSystem::Call::kRename, EIO);
    EXPECT_THROW(write_pieces(2), Error);
  }
  EXPECT_EQ(names(), (std::set<std::string>{"a.pvtu", "a_pieces", "a_pieces/a_0.vtu"}));
}

}  // namespace
}  // namespace tetfusion

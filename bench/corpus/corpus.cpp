// Simplifies a corpus of small meshes, made by counter, most of them odd, with options of all
// kinds, and has each result judged by `check` and by a judge that shares no code with the program.
// README.md says what is in it. Exit code 1 if a promise was broken, or a case has crashed.
//
//   corpus [--cases N] [--first N] [--jobs N] [--table] [--keep DIR]
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <vector>

#include "run_case.h"
#include "shapes.h"

namespace {

using corpus::Outcome;

constexpr unsigned kSeconds = 120;  // that a case may take

// Of a kind of mesh.
struct KindRow {
  std::uint64_t cases = 0, fused = 0, refused = 0, faults = 0, crashes = 0, before = 0, after = 0;
  std::uint64_t outside = 0;  // with a larger error than allowed at a point that lies outside
};

struct Settings {
  std::uint64_t first = 0, cases = 1000;
  unsigned jobs = 2;
  bool table = false;
  std::string keep;
};

std::string make_folder(const std::string& wanted) {
  if (!wanted.empty()) {
    std::filesystem::create_directories(wanted);
    return wanted;
  }
  // Thousands of small files: in memory, where that can be.
  std::error_code none;
  const bool shared = std::filesystem::is_directory("/dev/shm", none);
  std::string name = shared ? "/dev/shm/corpus-XXXXXX" : "/tmp/corpus-XXXXXX";
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a folder");
  return name;
}

// ---- In a process of its own: one that crashes takes nothing with it ----

std::string one_line(std::string text) {
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  return text;
}

void report(std::FILE* out, std::uint64_t number, const std::string& folder) {
  std::fprintf(out, "start %llu\n", static_cast<unsigned long long>(number));
  std::fflush(out);
  Outcome outcome;
  try {
    outcome = corpus::run_case(number, folder);
  } catch (const std::exception& error) {
    outcome.faults.push_back(std::string("threw: ") + error.what());
  }
  for (const std::string& fault : outcome.faults) {
    std::fprintf(out, "fault %s (%s)\n", one_line(fault).c_str(), outcome.options.c_str());
  }
  std::fprintf(out, "done %llu %llu %d\n", static_cast<unsigned long long>(outcome.before),
               static_cast<unsigned long long>(outcome.after), outcome.refused.empty() ? 0 : 1);
  std::fflush(out);
}

[[noreturn]] void work(int pipe, const std::vector<std::uint64_t>& numbers,
                       const std::string& keep) {
  std::FILE* out = ::fdopen(pipe, "w");
  const std::string folder = make_folder(keep);
  for (const std::uint64_t number : numbers) {
    ::alarm(kSeconds);
    report(out, number, folder);
  }
  if (keep.empty()) std::filesystem::remove_all(folder);
  std::fclose(out);
  ::_exit(0);
}

// ---- The one that starts them and listens ----

class Corpus {
 public:
  explicit Corpus(const Settings& settings) : settings_(settings) {}

  bool run() {
    std::vector<Job> jobs(settings_.jobs);
    for (unsigned j = 0; j < settings_.jobs; ++j) {
      for (std::uint64_t i = j; i < settings_.cases; i += settings_.jobs) {
        jobs[j].left.push_back(settings_.first + i);
      }
      start(&jobs[j]);
    }
    for (;;) {
      std::vector<pollfd> waiting;
      std::vector<Job*> of;
      for (Job& job : jobs) {
        if (job.pipe < 0) continue;
        waiting.push_back({job.pipe, POLLIN, 0});
        of.push_back(&job);
      }
      if (waiting.empty()) break;
      ::poll(waiting.data(), waiting.size(), -1);
      for (std::size_t i = 0; i < waiting.size(); ++i) {
        if (waiting[i].revents != 0) listen(of[i]);
      }
    }
    if (settings_.table) print_table();
    return print_sum();
  }

 private:
  struct Job {
    std::vector<std::uint64_t> left;  // the one in hand first
    pid_t process = -1;
    int pipe = -1;
    std::string text;
    bool begun = false, faulty = false, outside = false;  // the one in hand
  };

  KindRow& row(std::uint64_t number) { return rows_[number % corpus::kinds().size()]; }

  void start(Job* job) {
    if (job->left.empty()) return;
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("cannot make a pipe");
    std::fflush(nullptr);
    job->process = ::fork();
    if (job->process < 0) throw std::runtime_error("cannot start a process");
    if (job->process == 0) {
      ::close(ends[0]);
      work(ends[1], job->left, settings_.keep);
    }
    ::close(ends[1]);
    job->pipe = ends[0];
  }

  void listen(Job* job) {
    char buffer[4096];
    const ssize_t n = ::read(job->pipe, buffer, sizeof buffer);
    if (n > 0) {
      job->text.append(buffer, static_cast<std::size_t>(n));
      for (std::size_t end; (end = job->text.find('\n')) != std::string::npos;) {
        take(job, job->text.substr(0, end));
        job->text.erase(0, end + 1);
      }
      return;
    }
    ::close(job->pipe);
    job->pipe = -1;
    int status = 0;
    ::waitpid(job->process, &status, 0);
    if (!job->begun) return;
    const std::uint64_t number = job->left.front();
    std::cout << "case " << number << ", " << corpus::kinds()[number % corpus::kinds().size()].name
              << ": "
              << (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM ? "took too long" : "crashed")
              << std::endl;
    ++row(number).cases;
    ++row(number).crashes;
    job->left.erase(job->left.begin());
    job->text.clear();
    job->begun = job->faulty = job->outside = false;
    start(job);
  }

  void take(Job* job, const std::string& line) {
    std::istringstream in(line);
    std::string word;
    in >> word;
    if (word == "start") {
      job->begun = true;
      return;
    }
    const std::uint64_t number = job->left.front();
    KindRow& r = row(number);
    if (word == "fault") {
      const bool outside = line.find("fault error outside") == 0;
      std::cout << "case " << number << ", "
                << corpus::kinds()[number % corpus::kinds().size()].name << ": " << line.substr(6)
                << std::endl;
      (outside ? job->outside : job->faulty) = true;
      return;
    }
    std::uint64_t before = 0, after = 0;
    int refused = 0;
    in >> before >> after >> refused;
    ++r.cases;
    r.faults += job->faulty ? 1 : 0;
    r.outside += job->outside ? 1 : 0;
    r.refused += static_cast<std::uint64_t>(refused);
    if (refused == 0) {
      r.fused += after < before ? 1 : 0;
      r.before += before;
      r.after += after;
    }
    job->left.erase(job->left.begin());
    job->begun = job->faulty = job->outside = false;
  }

  void print_table() const {
    std::cout
        << "| kind | cases | simplified | tetrahedra gone % | refused | crashes | faults | error "
           "outside |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
    for (const auto& [kind, r] : rows_) print_row(corpus::kinds()[kind].name, r);
    print_row("**all**", sum());
  }

  static void print_row(const std::string& name, const KindRow& r) {
    const double gone =
        r.before == 0 ? 0
                      : 100 * (1 - static_cast<double>(r.after) / static_cast<double>(r.before));
    std::printf(
        "| %s | %llu | %llu | %.1f | %llu | %llu | %llu | %llu |\n", name.c_str(),
        static_cast<unsigned long long>(r.cases), static_cast<unsigned long long>(r.fused), gone,
        static_cast<unsigned long long>(r.refused), static_cast<unsigned long long>(r.crashes),
        static_cast<unsigned long long>(r.faults), static_cast<unsigned long long>(r.outside));
  }

  KindRow sum() const {
    KindRow all;
    for (const auto& [kind, r] : rows_) {
      all.cases += r.cases;
      all.fused += r.fused;
      all.refused += r.refused;
      all.faults += r.faults;
      all.outside += r.outside;
      all.crashes += r.crashes;
      all.before += r.before;
      all.after += r.after;
    }
    return all;
  }

  // A corpus that comes back as it was proves little; but single cells, and what is not sound,
  // stay.
  bool print_sum() const {
    const KindRow all = sum();
    std::cout << all.cases << " meshes, " << all.fused << " simplified, " << all.refused
              << " refused; " << all.crashes << " crashes, " << all.faults << " with faults, "
              << all.outside << " with a larger error than allowed at a point outside\n";
    const bool enough = all.cases < 200 || 3 * all.fused > all.cases;
    if (!enough) std::cout << "too few were simplified\n";
    return all.crashes == 0 && all.faults == 0 && all.cases == settings_.cases && enough;
  }

  const Settings& settings_;
  std::map<std::size_t, KindRow> rows_;
};

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app{"Simplifies a corpus of small odd meshes and judges the results"};
  app.add_option("--cases", settings.cases, "How many")->capture_default_str();
  app.add_option("--first", settings.first, "The number of the first one")->capture_default_str();
  app.add_option("--jobs", settings.jobs, "Processes at once")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--table", settings.table, "Print a table by kind");
  app.add_option("--keep", settings.keep,
                 "Leave in.vtu and out.vtu of the last case in this folder; with one job");
  CLI11_PARSE(app, argc, argv);
  if (!settings.keep.empty()) settings.jobs = 1;
  return Corpus(settings).run() ? 0 : 1;
}

// Small stages for the tests of the runner with real processes. The program's name selects the
// stage:
// - keypose-gather: photos (folder) -> images (folder): every file in capitals
// - keypose-join: images (folder) -> text (file): all files one after the other
// - keypose-merge: texts (files) -> all (folder): one file per text
// - keypose-capture, keypose-masks, keypose-silhouettes: photos, images or video (folder) -> images
//   or masked (folder): figure.txt, which holds the option `figure`
//
// Each writes its output in small pieces. Environment variables:
// - TEXT_STAGE_DELAY_MS: pause before each piece
// - TEXT_STAGE_SPAWN: start a long-lived child in its own session, like a careless external tool
// - TEXT_STAGE_WARNING: a warning that gather reports
// - TEXT_STAGE_GRADE: the grade that merge gives `rest`
// - TEXT_STAGE_LOG_LINES: number of additional log lines
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

volatile std::sig_atomic_t stop = 0;
void OnSignal(int) { stop = 1; }

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<fs::path> Sorted(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// The ports of a stage that is told what the figure is; none: another stage.
struct FigurePorts {
  const char* in = nullptr;
  const char* out = nullptr;
};
FigurePorts FigurePortsOf(const std::string& stage) {
  if (stage == "capture") return {"photos", "images"};
  if (stage == "masks") return {"images", "masked"};
  if (stage == "silhouettes") return {"video", "masked"};
  return {};
}

int Describe(const std::string& stage) {
  const auto port = [](const char* name, const char* kind, const char* file, bool many) {
    return json{{"name", name},       {"kind", kind},      {"file", file},
                {"repeatable", many}, {"optional", false}, {"help", ""}};
  };
  json inputs, outputs;
  if (stage == "gather")
    inputs = port("photos", "folder", "", false),
    outputs = port("images", "folder", "images", false);
  if (stage == "join")
    inputs = port("images", "folder", "", false), outputs = port("text", "file", "text.txt", false);
  if (stage == "merge")
    inputs = port("texts", "file", "", true), outputs = port("all", "folder", "all", false);
  const FigurePorts ports = FigurePortsOf(stage);
  if (ports.in)
    inputs = port(ports.in, "folder", "", false),
    outputs = port(ports.out, "folder", ports.out, false);
  const json code = {{"name", "exit_code"},
                     {"type", "int"},
                     {"default", 0},
                     {"unit", ""},
                     {"min", 0},
                     {"max", 255},
                     {"choices", json::array()},
                     {"help", ""}};
  json options = json::array({code});
  if (ports.in)
    options.push_back({{"name", "figure"},
                       {"type", "string"},
                       {"default", ""},
                       {"unit", ""},
                       {"min", nullptr},
                       {"max", nullptr},
                       {"choices", json::array()},
                       {"help", ""}});
  std::cout << json{{"schema", 1},
                    {"stage", stage},
                    {"version", "1"},
                    {"summary", "a test"},
                    {"inputs", json::array({inputs})},
                    {"outputs", json::array({outputs})},
                    {"options", options},
                    {"tools", json::array()},
                    {"resources", {{"cores", 1}, {"memory_bytes", 1 << 20}}}};
  return 0;
}

class Writer {
 public:
  explicit Writer(std::size_t pieces) : pieces_(pieces) {
    if (const char* text = std::getenv("TEXT_STAGE_DELAY_MS")) delay_ms_ = std::atoi(text);
    if (const char* text = std::getenv("KEYPOSE_PROGRESS_FD")) progress_fd_ = std::atoi(text);
  }
  void Write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream out(path, std::ios::binary | std::ios::app);
    for (std::size_t half = 0; half < 2; ++half) {
      out << text.substr(half ? text.size() / 2 : 0, half ? std::string::npos : text.size() / 2)
          << std::flush;
      if (!out) {
        std::cerr << "error: cannot write " << path << ": the disk is full\n";
        std::exit(4);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms_));
      if (stop) std::exit(130);
    }
    const std::string line =
        json{{"fraction", static_cast<double>(++done_) / static_cast<double>(pieces_)},
             {"what", "writing"}}
            .dump() +
        "\n";
    if (progress_fd_ >= 0 && write(progress_fd_, line.data(), line.size()) < 0) progress_fd_ = -1;
  }

 private:
  std::size_t pieces_, done_ = 0;
  int delay_ms_ = 0, progress_fd_ = -1;
};

void SpawnStray() {
  if (!std::getenv("TEXT_STAGE_SPAWN") || fork() != 0) return;
  setsid();
  std::signal(SIGTERM, SIG_IGN);
  std::this_thread::sleep_for(std::chrono::minutes(10));
  std::_Exit(0);
}

void WriteReport(const std::string& stage, const fs::path& path) {
  json report = {
      {"schema", 1}, {"stage", stage}, {"warnings", json::array()}, {"verdicts", json::array()}};
  if (const char* text = std::getenv("TEXT_STAGE_WARNING"); text && stage == "gather")
    report["warnings"].push_back(text);
  if (const char* grade = std::getenv("TEXT_STAGE_GRADE"); grade && stage == "merge")
    report["verdicts"].push_back({{"about", "rest"}, {"grade", grade}, {"why", "it was told so"}});
  std::ofstream(path) << report;
}

int Run(const std::string& stage, std::map<std::string, std::vector<std::string>> flags) {
  SpawnStray();
  std::cout << stage << " at work" << std::endl;
  const char* lines = std::getenv("TEXT_STAGE_LOG_LINES");
  for (int i = 0; i < (lines ? std::atoi(lines) : 0); ++i)
    std::cout << "line " << i << " of a long log\n";
  if (const FigurePorts ports = FigurePortsOf(stage); ports.in) {
    Writer(1).Write(fs::path(flags[ports.out][0]) / "figure.txt", flags["figure"][0]);
  } else if (stage == "gather") {
    const auto files = Sorted(flags["photos"][0]);
    Writer writer(files.size());
    for (const fs::path& file : files) {
      std::string text = ReadAll(file);
      std::transform(text.begin(), text.end(), text.begin(),
                     [](unsigned char c) { return std::toupper(c); });
      writer.Write(fs::path(flags["images"][0]) / file.filename(), text);
    }
  } else if (stage == "join") {
    const auto files = Sorted(flags["images"][0]);
    Writer writer(files.size());
    for (const fs::path& file : files) writer.Write(flags["text"][0], ReadAll(file));
  } else {
    Writer writer(flags["texts"].size());
    for (std::size_t i = 0; i < flags["texts"].size(); ++i)
      writer.Write(fs::path(flags["all"][0]) / (std::to_string(i) + ".txt"),
                   ReadAll(flags["texts"][i]));
  }
  WriteReport(stage, flags["report"][0]);
  const int code = std::atoi(flags["exit_code"][0].c_str());
  if (code) std::cerr << "keypose " << stage << ": error: told to fail\n";
  if (code == 139) std::raise(SIGSEGV);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);
  const std::string stage = fs::path(argv[0]).filename().string().substr(8);
  if (argc == 2 && std::string(argv[1]) == "--describe") return Describe(stage);
  if (argc > 1 && std::string(argv[1]) == "--check_options") return 0;
  std::map<std::string, std::vector<std::string>> flags;
  for (int i = 1; i + 1 < argc; i += 2) flags[argv[i] + 2].push_back(argv[i + 1]);
  return Run(stage, flags);
}

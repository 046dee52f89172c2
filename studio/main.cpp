// The program `keypose studio`: serves the studio's page for one project.
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "core/errors.h"
#include "pipeline/project_paths.h"
#include "studio/runs/children.h"
#include "studio/server/server.h"

namespace keypose::studio {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string folder;
  int port = 0;
  bool no_browser = false;
};

/// The project's folder: the given one, or the nearest parent with a pipeline.yaml, else this one.
fs::path FolderOf(const std::string& given) {
  const fs::path start =
      fs::absolute(given.empty() ? "." : pipeline::WithHome(given)).lexically_normal();
  if (!fs::is_directory(start))
    throw UsageError(fmt::format("-C {}: it is not a folder; make it first", start.string()));
  const fs::path clean = start.has_filename() ? start : start.parent_path();
  if (!given.empty()) return clean;
  for (fs::path folder = clean; folder != folder.root_path(); folder = folder.parent_path())
    if (fs::is_regular_file(folder / "pipeline.yaml")) return folder;
  return clean;
}

/// Opens the person's browser, if there is a desktop.
void OpenBrowser(const std::string& address) {
  const bool desktop = getenv("DISPLAY") || getenv("WAYLAND_DISPLAY");
  const char* const program = "/usr/bin/xdg-open";
  if (!desktop || access(program, X_OK) != 0) return;
  std::thread([address, program] { RunChild({program, address}, "/", 10); }).detach();
}

/// Waits for Ctrl-C or the end of the terminal in a thread of its own.
std::thread StopOnSignal(StudioServer& server, const sigset_t& signals) {
  return std::thread([&server, signals] {
    int signal = 0;
    sigwait(&signals, &signal);
    server.Stop();
  });
}

ExitCode Serve(const Options& options) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  StudioServer server({FolderOf(options.folder), options.port, &PageFiles()});
  fmt::print("{}\n", server.address());
  fmt::print("open it in a browser on this machine; Ctrl-C ends the studio\n");
  std::fflush(stdout);
  if (!options.no_browser) OpenBrowser(server.address());
  std::thread stopper = StopOnSignal(server, signals);
  server.Serve();
  kill(getpid(), SIGTERM);  // wakes the thread if the server ended by itself
  stopper.join();
  return ExitCode::kOk;
}

int Main(int argc, char** argv) {
  CLI::App app("The studio: photographs, masks, landmarks, timeline and hand-over in a web page.",
               "keypose studio");
  Options options;
  app.add_option("-C,--folder", options.folder,
                 "the project's folder, or an empty one for a new project");
  app.add_option("--port", options.port, "default: 4777, or the next free one")
      ->check(CLI::Range(1, 65535));
  app.add_flag("--no-browser", options.no_browser, "only print the address");
  try {
    app.parse(argc, argv);
    return static_cast<int>(Serve(options));
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "keypose: error: {}; see `keypose studio --help`\n", error.what());
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    fmt::print(stderr, "keypose: error: {}\n", error.what());
    return static_cast<int>(error.code());
  }
}

}  // namespace
}  // namespace keypose::studio

int main(int argc, char** argv) { return keypose::studio::Main(argc, argv); }

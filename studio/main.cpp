// The program `keypose studio`: serves the studio's page for one project.
#include <fmt/format.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
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
  // It may itself become the browser, for as long as that is open.
  LetGo({program, address}, "/");
}

/// Counts up when the studio shall end. A handler may do little more than write to it.
int stop_event = -1;

void AskToStop(int) { eventfd_write(stop_event, 1); }

/// Ctrl-C, `kill`, or the end of the terminal. A handler and not sigwait: libraries have threads of
/// their own, which would get the signal unblocked and end the program.
void HandleSignals() {
  stop_event = eventfd(0, EFD_CLOEXEC);
  struct sigaction action = {};
  action.sa_handler = AskToStop;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
}

std::thread StopWhenAsked(StudioServer& server) {
  return std::thread([&server] {
    eventfd_t count = 0;
    while (eventfd_read(stop_event, &count) != 0 && errno == EINTR) {
    }
    server.Stop();
  });
}

ExitCode Serve(const Options& options) {
  HandleSignals();
  StudioServer server({FolderOf(options.folder), options.port, &PageFiles()});
  fmt::print("{}\n", server.address());
  fmt::print("open it in a browser on this machine; Ctrl-C ends the studio\n");
  std::fflush(stdout);
  if (!options.no_browser) OpenBrowser(server.address());
  std::thread stopper = StopWhenAsked(server);
  server.Serve();
  eventfd_write(stop_event, 1);  // the server may have ended by itself
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

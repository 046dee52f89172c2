// The studio's HTTP server, on the loopback only.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "studio/http/page_files.h"

namespace keypose::studio {

struct ServerOptions {
  std::filesystem::path
      folder;                  ///< of the project, or where one is to be made; empty: the page asks
  std::filesystem::path home;  ///< where the page makes new projects
  std::optional<int> port;     ///< none: 4777, or the next free one; 0: any
  const std::vector<PageFile>* page = nullptr;  ///< must outlive the server
};

class StudioServer {
 public:
  /// Binds the port, so that the address can be printed before the first request comes.
  /// @throws UsageError  the wanted port is taken
  explicit StudioServer(const ServerOptions& options);
  ~StudioServer();

  /// The address that lets one browser in, once.
  const std::string& address() const { return address_; }
  /// Another one, for another browser.
  std::string NewAddress();
  /// Calls `print` with a new address when a browser that is not let in asks for one; at most once
  /// in ten seconds. What is printed, only the person at this terminal reads.
  void OnAsked(std::function<void(const std::string& address)> print);
  /// Calls `end` when the page asks for the studio's end.
  void OnEnd(std::function<void()> end);
  /// From now on AddressOfRunning finds this one. For a studio that began without a project.
  void TellOthers() const;
  /// The project that is open; empty: none.
  std::filesystem::path folder() const;
  bool IsRunning() const;
  /// Answers requests until Stop.
  void Serve();
  /// May be called from another thread.
  void Stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string address_;
};

/// A new address of the studio of this person that is at work on this machine and began without a
/// project; "" if there is none.
std::string AddressOfRunning();

}  // namespace keypose::studio

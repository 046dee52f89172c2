// The studio's HTTP server, on the loopback only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "studio/http/page_files.h"

namespace keypose::studio {

struct ServerOptions {
  std::filesystem::path folder;                 ///< of the project, or where one is to be made
  int port = 0;                                 ///< 0: 4777, or the next free one
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
  /// Answers requests until Stop.
  void Serve();
  /// May be called from another thread.
  void Stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string address_;
};

}  // namespace keypose::studio

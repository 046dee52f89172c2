// SHA-256, the hash that is used for file contents and fingerprints.
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace keypose {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  void Add(std::string_view bytes);
  /// The hash of all added bytes, as 64 hexadecimal digits. Call it once.
  std::string Hex();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string Sha256Of(std::string_view bytes);

}  // namespace keypose

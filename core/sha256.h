// SHA-256, the hash of contents and fingerprints.
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
  /// 64 hexadecimal digits of all that was added; call once.
  std::string Hex();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string Sha256Of(std::string_view bytes);

}  // namespace keypose

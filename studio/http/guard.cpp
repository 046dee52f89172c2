#include "studio/http/guard.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace keypose::studio {
namespace {

constexpr std::uint64_t kMostJsonBytes = 32u << 20;  // a painted stiffness of a million vertices
constexpr std::uint64_t kMostPictureBytes = 512u << 20;

bool Same(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

/// Paths that take pictures; all others take a JSON text.
bool TakesPicture(const std::string& path) { return path == "/api/photos" || path == "/api/mask"; }

}  // namespace

std::string RandomDigits(int bits) {
  std::vector<unsigned char> bytes(static_cast<std::size_t>(bits / 8));
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    throw std::runtime_error("the system has no random numbers");
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

Guard::Guard(std::string token, std::string session, int port)
    : token_(std::move(token)),
      session_(std::move(session)),
      cookie_(fmt::format("keypose_{}", port)),
      port_(port) {}

std::optional<std::string> Guard::Enter(const std::string& token) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (token_.empty() || !Same(token, token_)) return std::nullopt;
  token_.clear();
  // As long as the session is kept: who has closed the browser overnight goes on in the morning.
  return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/; Max-Age=2592000", cookie_,
                     session_);
}

std::string Guard::NewToken() {
  const std::string token = RandomDigits(128);
  const std::lock_guard<std::mutex> lock(mutex_);
  return token_ = token;
}

bool Guard::HasCookie(const std::string& cookies) const {
  std::size_t at = 0;
  while (at < cookies.size()) {
    std::size_t end = std::min(cookies.find(';', at), cookies.size());
    const std::string one = cookies.substr(at, end - at);
    if (Same(one, cookie_ + "=" + session_)) return true;
    at = cookies.find_first_not_of("; ", end);
  }
  return false;
}

std::optional<Refusal> Guard::JudgePlace(const RequestHead& head) const {
  const std::string here = fmt::format("127.0.0.1:{}", port_);
  const std::string named = fmt::format("localhost:{}", port_);
  // A name that somebody else's DNS points at this machine is no way in.
  if (head.host != here && head.host != named)
    return Refusal{403, "this address is not the studio's"};
  if (!head.origin.empty() && head.origin != "http://" + head.host)
    return Refusal{403, "another page asked for this"};
  const bool entering = head.path == "/enter";
  if (!head.fetch_site.empty() && head.fetch_site != "same-origin" && head.fetch_site != "none" &&
      !entering)
    return Refusal{403, "another page asked for this"};
  return std::nullopt;
}

std::optional<Refusal> Guard::Judge(const RequestHead& head) const {
  if (auto refusal = JudgePlace(head)) return refusal;
  if (head.path == "/enter" && head.method == "GET") return std::nullopt;
  if (!HasCookie(head.cookies))
    return Refusal{403,
                   "open the address that `keypose studio` printed; each address lets one browser "
                   "in: for another one press Enter where it was printed"};
  if (head.method == "GET" || head.method == "HEAD") return std::nullopt;
  if (head.method != "POST" && head.method != "PUT")
    return Refusal{405, "the studio knows GET, POST and PUT"};
  if (head.own_header != "1") return Refusal{403, "only the studio's own page may change things"};
  const std::uint64_t most = TakesPicture(head.path) ? kMostPictureBytes : kMostJsonBytes;
  if (head.body_bytes > most)
    return Refusal{413, fmt::format("that is larger than {} MB", most >> 20)};
  return std::nullopt;
}

}  // namespace keypose::studio

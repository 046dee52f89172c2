#!/usr/bin/env bash
# A server by Debian's cpp-httplib compresses every text that it sends, unasked, by Brotli at its highest quality, as soon
# as the client names `br`, which all browsers do. There is no setting for it; only content given by a provider of known
# length goes out as it is.
#
# Seen with: Debian 12's libcpp-httplib-dev 0.11.4+ds-1+deb12u1, libbrotli 1.0.9-2+b6, its g++ 12.
# Input: a server on the loopback with one JavaScript text of about 1 MB, asked for with `Accept-Encoding: br`.
# Output: `Content-Encoding: br`, and as many bytes as Brotli's own encoder makes at quality 11, fewer than at 5; the
# same text by a provider: no such header, the text's own length.
# Why it matters: quality 11 takes seconds of processor time for a page's program, at each load, to save what costs
# nothing on one machine; it shows as a page that is slow to appear.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install libcpp-httplib-dev=0.11.4+ds-1+deb12u1 libcpp-httplib0.11=0.11.4+ds-1+deb12u1 \
  libbrotli-dev=1.0.9-2+b6 libbrotli1=1.0.9-2+b6 libssl-dev libssl3 zlib1g-dev zlib1g >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done

cat >server.cpp <<'CPP'
#define CPPHTTPLIB_BROTLI_SUPPORT
#define CPPHTTPLIB_ZLIB_SUPPORT
#define CPPHTTPLIB_OPENSSL_SUPPORT
#include <brotli/encode.h>
#include <httplib.h>

#include <cstdio>

std::size_t Compressed(const std::string& text, int quality) {
  std::size_t size = BrotliEncoderMaxCompressedSize(text.size());
  std::string out(size, '\0');
  BrotliEncoderCompress(quality, BROTLI_DEFAULT_WINDOW, BROTLI_MODE_GENERIC, text.size(),
                        reinterpret_cast<const std::uint8_t*>(text.data()), &size,
                        reinterpret_cast<std::uint8_t*>(out.data()));
  return size;
}

int main() {
  std::string text;
  for (unsigned i = 0; text.size() < 1000000; ++i)
    text += "function f" + std::to_string(i * 2654435761u) + "(a) { return a * " + std::to_string(i * i) + "; }\n";
  httplib::Server server;
  server.Get("/plain", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content(text, "application/javascript");
  });
  server.Get("/provided", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content_provider(text.size(), "application/javascript",
                                  [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                    return sink.write(text.data() + offset, length);
                                  });
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  std::thread thread([&] { server.listen_after_bind(); });
  httplib::Client client("127.0.0.1", port);
  client.set_decompress(false);
  client.set_read_timeout(120);
  for (const char* path : {"/plain", "/provided"}) {
    const auto answer = client.Get(path, {{"Accept-Encoding", "br"}});
    if (!answer) return 2;
    const std::size_t size = answer->body.size();
    std::printf("%s: encoding '%s', %s\n", path, answer->get_header_value("Content-Encoding").c_str(),
                size == text.size() ? "as it is"
                : size < Compressed(text, 5) && size <= Compressed(text, 11) + 16 ? "as small as at quality 11"
                                                                                    : "larger than at quality 11");
  }
  server.stop();
  thread.join();
}
CPP
g++ -O1 -std=c++17 -isystem root/usr/include -isystem root/usr/include/x86_64-linux-gnu server.cpp -o server \
  -Lroot/usr/lib/x86_64-linux-gnu -lcpp-httplib -lbrotlienc -lbrotlidec -lbrotlicommon -lssl -lcrypto -lz -pthread
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./server | tee result
if [ "$(cat result)" = "/plain: encoding 'br', as small as at quality 11
/provided: encoding '', as it is" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi

#include "studio/routes/upload_routes.h"

#include <charconv>

#include "core/values/errors.h"
#include "studio/project/uploads.h"

namespace keypose::studio {

namespace {

std::uint64_t BytesFrom(const std::string& text) {
  std::uint64_t bytes = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
  if (error != std::errc() || end != text.data() + text.size())
    throw UsageError("a number of bytes was expected");
  return bytes;
}

}  // namespace

void UploadRoutes::AddTo(RouteTable& table) {
  table.Put(
      "/api/upload",
      [this](const Question& question) {
        const UploadPiece piece = {question.Need("place"), question.Get("shot"),
                                   question.Need("name"), BytesFrom(question.Need("at")),
                                   BytesFrom(question.Need("size"))};
        const Upload upload = project_.WithFolder([&](const std::filesystem::path& folder) {
          return TakePiece(folder, piece, question.body);
        });
        return JsonAnswer({{"sent", upload.sent}, {"file", upload.file}});
      },
      Changes::kQuietly);
}

}  // namespace keypose::studio

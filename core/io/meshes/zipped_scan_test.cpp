#include "core/io/meshes/zipped_scan.h"

#include <archive.h>
#include <archive_entry.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/pictures/picture_bytes.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::zipped_scan_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Files = std::vector<std::pair<std::string, std::string>>;

const std::string kObj =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

class ZippedScanTest : public ::testing::Test, public TestingFolder {
 protected:
  fs::path Zip(const Files& files, const std::string& name = "a.zip") {
    archive* zip = archive_write_new();
    archive_write_set_format_zip(zip);
    archive_write_open_filename(zip, (folder_ / name).c_str());
    for (const auto& [file, text] : files) {
      archive_entry* entry = archive_entry_new();
      archive_entry_set_pathname(entry, file.c_str());
      archive_entry_set_size(entry, static_cast<la_int64_t>(text.size()));
      archive_entry_set_filetype(entry, AE_IFREG);
      archive_entry_set_perm(entry, 0644);
      archive_write_header(zip, entry);
      archive_write_data(zip, text.data(), text.size());
      archive_entry_free(entry);
    }
    archive_write_free(zip);
    return folder_ / name;
  }
  std::string Refusal(const Files& files, const std::string& name = "a.zip") {
    try {
      ReadScan(Zip(files, name));
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
      return error.what();
    }
    return "was read";
  }
};

TEST_F(ZippedScanTest, TheMeshInItIsReadWithItsTexture) {
  const std::string picture = PngBytes(Image8(4, 4, 3, 90));
  const Scan scan = ReadScan(Zip({{"scan/a.obj", kObj},
                                  {"scan/a.mtl", "newmtl a\nmap_Kd maps/a.png\n"},
                                  {"scan/maps/a.png", picture},
                                  {"__MACOSX/scan/._a.obj", "x"},
                                  {"readme.txt", "x"}}));
  EXPECT_EQ(scan.mesh.face_count(), 1);
  EXPECT_EQ(scan.texture, picture);
  EXPECT_TRUE(scan.changed);
  EXPECT_EQ(scan.texture_file, "") << "which is gone by now";
}

TEST_F(ZippedScanTest, TheFolderGoesWithIt) {
  fs::path mesh;
  {
    const ZippedScan unpacked(Zip({{"a.obj", kObj}}));
    mesh = unpacked.mesh();
    EXPECT_EQ(ReadFile(mesh), kObj);
  }
  EXPECT_FALSE(fs::exists(mesh));
  EXPECT_FALSE(fs::exists(mesh.parent_path()));
}

TEST_F(ZippedScanTest, WhatIsNotReadIsNamed) {
  EXPECT_THAT(Refusal({{"scan.usdc", "PXR-USDC"}, {"0/a.png", "x"}}, "room.usdz"),
              HasSubstr("a USD scene (scan.usdc)"));
  EXPECT_THAT(Refusal({{"a.obj", kObj}, {"b.obj", kObj}}), HasSubstr("2 meshes (a.obj, b.obj)"));
  EXPECT_THAT(Refusal({{"a.txt", "x"}}), HasSubstr("without a mesh"));
  EXPECT_THAT(Refusal({{"../a.obj", kObj}}), HasSubstr("leads elsewhere"));
  EXPECT_THAT(Refusal({{"a.obj", std::string("PK\x03\x04", 4)}}), HasSubstr("holds a ZIP file"));
  const std::string whole = ReadFile(Zip({{"a.obj", kObj}}));
  WriteFile(folder_ / "b.zip", whole.substr(0, 40));
  EXPECT_THROW(ReadScan(folder_ / "b.zip"), InputError);
  EXPECT_THROW(ReadMesh(Zip({{"a.obj", kObj}})), InputError);
}

TEST_F(ZippedScanTest, OtherFilesInItAreNamed) {
  EXPECT_THAT(Refusal({{"3D/3dmodel.model", "<model/>"}, {"[Content_Types].xml", "<x/>"}}),
              ::testing::AllOf(HasSubstr("is a 3MF file"), HasSubstr("slicer")));
  EXPECT_THAT(Refusal({{"scan.fbx", "Kaydara FBX"}}), HasSubstr("holds an FBX file (scan.fbx)"));
}

}  // namespace keypose::zipped_scan_test

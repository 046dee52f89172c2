# cmake -DPAGE=folder -DOUTPUT=page.cpp -P embed_page.cmake: the page's files as strings of the program.
file(GLOB files RELATIVE ${PAGE} ${PAGE}/*)
list(SORT files)
set(strings "")
set(table "")
set(number 0)
foreach(name IN LISTS files)
  file(READ "${PAGE}/${name}" text)
  string(FIND "${text}" ")keypose_page" ends)
  if(NOT ends EQUAL -1)
    message(FATAL_ERROR "${name} holds the mark that would end its string; choose another in embed_page.cmake")
  endif()
  string(APPEND strings "const char kFile${number}[] = R\"keypose_page(${text})keypose_page\";\n")
  string(APPEND table "      {\"${name}\", std::string_view(kFile${number}, sizeof kFile${number} - 1)},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUTPUT}" "#include \"studio/http/page_files.h\"\n
namespace keypose::studio {
namespace {
${strings}}  // namespace

const std::vector<PageFile>& PageFiles() {
  static const std::vector<PageFile> kFiles = {
${table}  };
  return kFiles;
}
}  // namespace keypose::studio\n")

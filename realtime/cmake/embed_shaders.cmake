# cmake -DFOLDER=.. -DOUTPUT=.. -P embed_shaders.cmake
# Writes a C++ file with every shader of the folder as a raw string: the program needs no files to run.
file(GLOB shaders RELATIVE ${FOLDER} ${FOLDER}/*.vert ${FOLDER}/*.geom ${FOLDER}/*.frag ${FOLDER}/*.comp
     ${FOLDER}/*.glsl)
list(SORT shaders)
set(text "#include \"realtime/shader.h\"\n\nnamespace pluvia {\n\n")
string(APPEND text "const ShaderFiles& embedded_shaders() {\n  static const ShaderFiles files = {\n")
foreach(name ${shaders})
  file(READ ${FOLDER}/${name} source)
  string(APPEND text "{\"${name}\", R\"glsl(${source})glsl\"},\n")
endforeach()
string(APPEND text "  };\n  return files;\n}\n\n}  // namespace pluvia\n")
file(WRITE ${OUTPUT} "${text}")

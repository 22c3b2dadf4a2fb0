# Writes a C++ file with the text of the catalogue of stars: cmake -DOUTPUT=FILE -DCATALOGUE=FILE -P embed_stars.cmake
file(READ "${CATALOGUE}" content)
file(WRITE "${OUTPUT}" "#include \"scene/bright_stars.h\"\n\nnamespace tellurion::scene {\n\nconst std::string_view kBrightStars = R\"stars(${content})stars\";\n\n}  // namespace tellurion::scene\n")

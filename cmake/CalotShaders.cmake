# calot_embed_shaders(TARGET FOLDER): every FOLDER/*.glsl as text inside the program, found by its file name.
function(calot_embed_shaders target folder)
  file(GLOB shaders CONFIGURE_DEPENDS ${folder}/*.glsl)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/shader_texts.cpp)
  set(script ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embed_shaders.cmake)
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} "-DSHADERS=${shaders}" -DOUT=${out} -P ${script}
    DEPENDS ${shaders} ${script} VERBATIM COMMENT "Embedding shaders")
  target_sources(${target} PRIVATE ${out})
endfunction()

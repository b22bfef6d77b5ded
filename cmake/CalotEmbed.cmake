# calot_embed_file(TARGET SYMBOL FILE): the bytes of FILE inside the program, between the symbols SYMBOL_begin and
# SYMBOL_end. The assembler reads them, so that large files cost the compiler nothing.
function(calot_embed_file target symbol file)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${symbol}.cpp)
  file(CONFIGURE OUTPUT ${out} @ONLY CONTENT [[
// Made from @file@.
asm(R"(
    .section .rodata
    .balign 16
    .global @symbol@_begin
    .global @symbol@_end
@symbol@_begin:
    .incbin "@file@"
@symbol@_end:
    .byte 0
    .text
)");
]])
  set_source_files_properties(${out} PROPERTIES OBJECT_DEPENDS ${file})
  target_sources(${target} PRIVATE ${out})
endfunction()

# contact_patch::contact_patch: the shared library; contact_patch::static: the static one, with what it links to.
# Installed by capi/install.sh to PREFIX/lib/cmake/contact_patch.
get_filename_component(contact_patch_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(contact_patch_VERSION "@VERSION@")

if(NOT TARGET contact_patch::contact_patch)
  add_library(contact_patch::contact_patch SHARED IMPORTED)
  set_target_properties(contact_patch::contact_patch PROPERTIES
    IMPORTED_LOCATION "${contact_patch_PREFIX}/lib/${CMAKE_SHARED_LIBRARY_PREFIX}contact_patch_c${CMAKE_SHARED_LIBRARY_SUFFIX}"
    IMPORTED_NO_SONAME TRUE
    INTERFACE_INCLUDE_DIRECTORIES "${contact_patch_PREFIX}/include")

  add_library(contact_patch::static STATIC IMPORTED)
  set_target_properties(contact_patch::static PROPERTIES
    IMPORTED_LOCATION "${contact_patch_PREFIX}/lib/${CMAKE_STATIC_LIBRARY_PREFIX}contact_patch_c${CMAKE_STATIC_LIBRARY_SUFFIX}"
    INTERFACE_INCLUDE_DIRECTORIES "${contact_patch_PREFIX}/include"
    INTERFACE_LINK_LIBRARIES "@LIBRARIES@")
endif()

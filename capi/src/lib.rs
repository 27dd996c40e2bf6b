//! The C interface: texts and objects over the border, no panic across it. What each function does is written in
//! `include/contact_patch.h`.

mod border;
mod contact;
mod curve;
mod scene;

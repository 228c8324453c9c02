//! starbreak

//! Boxes, outlines and masks under maps that can be computed.

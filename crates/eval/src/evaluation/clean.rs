use serde::{Deserialize, Serialize};

use super::{LabelAudit, ProtocolResults, TideErrors, Warning};

/// What a detector does on the clean images: the same for all conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CleanResults {
    /// Name of the detector.
    pub detector: String,
    /// What a reader must know first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Warning>,
    /// Whole images by the protocol.
    pub results: ProtocolResults,
    /// Which kinds of errors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tide: Option<TideErrors>,
    /// Whether the classes are the right ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label_audit: Option<LabelAudit>,
}

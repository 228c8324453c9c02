//! Ground truth of a part of its images.

use super::{GroundTruth, Protocol, SaidDetections};
use crate::{
    Detection, Detections, KittiDetections, KittiLabels, LabelSet, LabeledImage, bdd_detections,
};

/// Of each image its place among those that are kept.
type NewPlaces = Vec<Option<u32>>;

impl GroundTruth {
    /// The same without the images that are not kept, and where those that are kept now stand.
    #[must_use]
    pub fn keep(&self, is_kept: impl Fn(&LabeledImage) -> bool) -> (Self, Vec<Option<u32>>) {
        let (labels, places) = kept_labels(&self.labels, &is_kept).0;
        let kitti = self.kitti.as_ref().map(|kitti| {
            let ((set, _), objects) = kept_labels(&kitti.set, &is_kept);
            let facts = kitti.facts.iter().zip(&objects);
            KittiLabels {
                set,
                facts: facts
                    .filter_map(|(facts, is_kept)| is_kept.then_some(*facts))
                    .collect(),
            }
        });
        let truth = Self {
            protocol: self.protocol,
            labels,
            kitti,
            root: self.root.clone(),
        };
        (truth, places)
    }

    /// Detections in pixels of these labels' images, in the convention of the protocol.
    #[must_use]
    pub fn said(&self, detections: &Detections) -> SaidDetections {
        let detections = match self.protocol {
            Protocol::Bdd => bdd_detections(detections),
            Protocol::Coco | Protocol::Kitti => detections.clone(),
        };
        SaidDetections {
            kitti: (self.protocol == Protocol::Kitti)
                .then(|| KittiDetections::of(&detections, &self.labels)),
            detections,
            unused: None,
        }
    }
}

impl Detections {
    /// The detections in the images that [`GroundTruth::keep`] has kept, by their new places.
    #[must_use]
    pub fn keep(&self, places: &[Option<u32>]) -> Self {
        let items = self.items.iter().filter_map(|detection| {
            let image = (*places.get(detection.image as usize)?)?;
            Some(Detection {
                image,
                ..*detection
            })
        });
        Self {
            items: items.collect(),
        }
    }
}

/// The labels of the kept images with the new places of images, and which objects are kept.
fn kept_labels(
    labels: &LabelSet,
    is_kept: &dyn Fn(&LabeledImage) -> bool,
) -> ((LabelSet, NewPlaces), Vec<bool>) {
    let mut next = 0;
    let mut images = Vec::new();
    let places: NewPlaces = labels
        .images
        .iter()
        .map(|image| {
            let place = next;
            is_kept(image).then(|| {
                images.push(image.clone());
                next += 1;
                place
            })
        })
        .collect();
    let place_of = |image: u32| places.get(image as usize).copied().flatten();
    let objects: Vec<bool> = labels
        .objects
        .iter()
        .map(|object| place_of(object.image).is_some())
        .collect();
    let kept_objects = labels.objects.iter().filter_map(|object| {
        let mut object = object.clone();
        object.image = place_of(object.image)?;
        Some(object)
    });
    let labels = LabelSet {
        images,
        categories: labels.categories.clone(),
        objects: kept_objects.collect(),
    };
    ((labels, places), objects)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoxPx, Category, Object, ObjectKind};

    fn truth() -> GroundTruth {
        let image = |id: i64| LabeledImage {
            id,
            name: format!("{id}.png"),
            width_px: None,
            height_px: None,
            cluster: None,
        };
        let object = |image: u32, id: i64| Object {
            id,
            image,
            category: 0,
            box_px: BoxPx::from_corners([0.0, 0.0, 4.0, 4.0]),
            area_px2: 16.0,
            kind: ObjectKind::Regular,
        };
        GroundTruth {
            protocol: Protocol::Coco,
            labels: LabelSet {
                images: vec![image(1), image(2), image(3)],
                categories: vec![Category {
                    id: 1,
                    name: "car".to_owned(),
                    supercategory: None,
                }],
                objects: vec![object(2, 30), object(0, 10), object(1, 20), object(2, 31)],
            },
            kitti: None,
            root: None,
        }
    }

    #[test]
    fn objects_and_detections_follow_their_images() {
        let (kept, places) = truth().keep(|image| image.id != 2);
        assert_eq!(places, [Some(0), None, Some(1)], "new places");
        let ids: Vec<(u32, i64)> = kept
            .labels
            .objects
            .iter()
            .map(|o| (o.image, o.id))
            .collect();
        assert_eq!(ids, [(1, 30), (0, 10), (1, 31)], "in their order");
        let detection = |image| Detection {
            image,
            category: 0,
            box_px: BoxPx::from_corners([0.0, 0.0, 4.0, 4.0]),
            score: 0.5,
        };
        let all = Detections {
            items: vec![detection(1), detection(2)],
        };
        let images: Vec<u32> = all.keep(&places).items.iter().map(|d| d.image).collect();
        assert_eq!(images, [1], "that of the second image is gone");
    }
}

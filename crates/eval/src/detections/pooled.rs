//! Categories pooled by their groups.

use crate::{Category, LabelSet};

/// Which group each category belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Pooling {
    /// The groups as categories, in the order in which they occur first.
    pub categories: Vec<Category>,
    /// The place of its group, category by category.
    pub group_of: Vec<u32>,
}

impl LabelSet {
    /// The groups of the categories, where there are fewer groups than categories and every
    /// category has one.
    #[must_use]
    pub(crate) fn by_supercategory(&self) -> Option<Pooling> {
        let mut categories: Vec<Category> = Vec::new();
        let mut group_of = Vec::with_capacity(self.categories.len());
        for category in &self.categories {
            let name = category.supercategory.as_ref()?;
            let known = categories.iter().position(|group| &group.name == name);
            let place = known.unwrap_or_else(|| {
                categories.push(Category {
                    id: i64::try_from(categories.len() + 1).unwrap_or(i64::MAX),
                    name: name.clone(),
                    supercategory: None,
                });
                categories.len() - 1
            });
            group_of.push(u32::try_from(place).ok()?);
        }
        (categories.len() < self.categories.len()).then_some(Pooling {
            categories,
            group_of,
        })
    }
}

impl Pooling {
    /// The group of a category; beyond all groups where there is no such category.
    #[must_use]
    pub fn group(&self, category: u32) -> u32 {
        self.group_of
            .get(category as usize)
            .copied()
            .unwrap_or(u32::MAX)
    }
}

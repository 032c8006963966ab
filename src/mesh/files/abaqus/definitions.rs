//! Data of a deck besides its meshes: materials, contact pairs, supports.

use super::lines::{Data, Keyword};

/// Property of a material: the keyword with its parameters, and the numbers of its data lines.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckProperty {
    /// Keyword in capitals, such as `HYPERELASTIC`.
    pub keyword: String,
    /// Names and values of its parameters in capitals, such as `("N", "3")`.
    pub parameters: Vec<(String, String)>,
    /// All numbers of the data lines; NaN for an entry that is not a number.
    pub numbers: Vec<f64>,
}

/// Material of an Abaqus or CalculiX input file (deck).
#[derive(Clone, Debug, PartialEq)]
pub struct DeckMaterial {
    /// Name of the material as the deck writes it.
    pub name: String,
    /// Material properties in the order of the file.
    pub properties: Vec<DeckProperty>,
}

/// Two surfaces that touch or are tied, by their names as written.
pub(super) struct Pair {
    pub secondary: String,
    pub primary: String,
    pub is_tied: bool,
}

/// Materials, contact pairs and supports of a deck.
#[derive(Default)]
pub(super) struct Definitions {
    /// Materials in the order of the file.
    pub materials: Vec<DeckMaterial>,
    pub pairs: Vec<Pair>,
    /// Node sets with fixed directions, by their names as written, with the last fixed direction (the first one is 1).
    pub held: Vec<(String, usize)>,
}

/// Meaning of the data lines that follow a keyword.
#[derive(Clone, Copy)]
pub(super) enum Statement {
    Property,
    Pair { is_tied: bool },
    Support,
}

impl Definitions {
    /// Meaning of the data lines that follow a keyword of materials, contact pairs or supports; `None` for other keywords.
    pub fn open(&mut self, keyword: &Keyword) -> Option<Statement> {
        match &*keyword.name {
            "MATERIAL" => {
                let name = keyword.value("NAME").unwrap_or_default().into();
                self.materials.push(DeckMaterial { name, properties: Vec::new() });
                None
            }
            "ELASTIC" | "HYPERELASTIC" | "DENSITY" => {
                let material = self.materials.last_mut()?;
                let parameters = keyword.parameters().map(|(name, value)| (name.into(), value.to_ascii_uppercase())).collect();
                material.properties.push(DeckProperty { keyword: keyword.name.clone(), parameters, numbers: Vec::new() });
                Some(Statement::Property)
            }
            "CONTACT PAIR" => Some(Statement::Pair { is_tied: keyword.value("TIED").is_some() }),
            "TIE" => Some(Statement::Pair { is_tied: true }),
            "BOUNDARY" => Some(Statement::Support),
            _ => None,
        }
    }

    /// Reads a data line of a keyword.
    pub fn data(&mut self, statement: Statement, data: &Data) {
        let mut fields = data.fields();
        match statement {
            Statement::Property => {
                if let Some(property) = self.materials.last_mut().and_then(|material| material.properties.last_mut()) {
                    property.numbers.extend(fields.map(|field| data.real(Some(field), "").unwrap_or(f64::NAN)));
                }
            }
            Statement::Pair { is_tied } => {
                if let (Some(secondary), Some(primary)) = (fields.next(), fields.next().filter(|name| !name.is_empty())) {
                    self.pairs.push(Pair { secondary: secondary.into(), primary: primary.into(), is_tied });
                }
            }
            Statement::Support => {
                let (name, first) = (fields.next().unwrap_or_default(), fields.next().unwrap_or_default().to_ascii_uppercase());
                let last = fields.next().unwrap_or_default();
                let last = match &*first {
                    "ENCASTRE" | "PINNED" => Some(6),
                    "1" => last.parse().ok(),
                    _ => None,
                };
                let is_zero = fields.next().is_none_or(|value| matches!(data.real(Some(value), ""), Ok(0.0)));
                if let Some(last) = last
                    && is_zero
                    && name.parse::<u64>().is_err()
                    && !self.held.iter().any(|(known, _)| known == name)
                {
                    self.held.push((name.into(), last));
                }
            }
        }
    }
}

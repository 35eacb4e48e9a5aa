//! Mapbox Vector Tiles 2.1: the few protocol-buffer messages that they are made of.
//!
//! Crates that encode them either bring a compiler of schemas or a geometry library of their own; the messages are four, written here from the specification.

use std::collections::BTreeMap;

/// Units a side of a tile.
pub(super) const EXTENT: i32 = 4096;

/// A value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Double(f64),
    Int(i64),
    Bool(bool),
}

impl Value {
    fn bytes(&self) -> Vec<u8> {
        let mut message = Message::default();
        match self {
            Self::Text(text) => message.bytes(1, text.as_bytes()),
            Self::Double(number) => message.fixed64(3, number.to_bits()),
            Self::Int(number) => message.whole(6, zigzag(*number)),
            Self::Bool(value) => message.whole(7, u64::from(*value)),
        }
        message.0
    }
}

/// A geometry in units of the tile, counted from its north-west corner to the east and to the south.
pub(super) enum Geometry {
    Point([i32; 2]),
    Lines(Vec<Vec<[i32; 2]>>),
    /// Rings without their last vertex: the outer ones run clockwise as seen on the map, holes the other way round.
    Polygon(Vec<Vec<[i32; 2]>>),
}

/// A layer of a tile.
pub(super) struct Layer {
    name: &'static str,
    features: Message,
    count: usize,
    keys: BTreeMap<String, u64>,
    values: BTreeMap<Vec<u8>, u64>,
}

impl Layer {
    pub(super) fn new(name: &'static str) -> Self {
        Self { name, features: Message::default(), count: 0, keys: BTreeMap::new(), values: BTreeMap::new() }
    }

    /// Adds a feature; a geometry without parts is left out.
    pub(super) fn add(&mut self, id: Option<u64>, properties: &[(impl AsRef<str>, Value)], geometry: &Geometry) {
        let (kind, commands) = commands(geometry);
        if commands.is_empty() {
            return;
        }
        let mut tags = Vec::new();
        for (key, value) in properties {
            let next = self.keys.len() as u64;
            tags.push(*self.keys.entry(key.as_ref().to_owned()).or_insert(next));
            let next = self.values.len() as u64;
            tags.push(*self.values.entry(value.bytes()).or_insert(next));
        }
        let mut feature = Message::default();
        if let Some(id) = id {
            feature.whole(1, id);
        }
        feature.packed(2, &tags);
        feature.whole(3, kind);
        feature.packed(4, &commands);
        self.features.bytes(2, &feature.0);
        self.count += 1;
    }

    fn bytes(self) -> Vec<u8> {
        let mut message = Message::default();
        message.bytes(1, self.name.as_bytes());
        message.0.extend(self.features.0);
        for (key, _) in in_order(self.keys) {
            message.bytes(3, key.as_bytes());
        }
        for (value, _) in in_order(self.values) {
            message.bytes(4, &value);
        }
        message.whole(5, EXTENT as u64);
        message.whole(15, 2);
        message.0
    }
}

/// What was numbered, by its number.
fn in_order<K>(numbered: BTreeMap<K, u64>) -> Vec<(K, u64)> {
    let mut all: Vec<_> = numbered.into_iter().collect();
    all.sort_by_key(|(_, number)| *number);
    all
}

/// A tile of layers; those without features are left out.
pub(super) fn encode(layers: Vec<Layer>) -> Vec<u8> {
    let mut tile = Message::default();
    for layer in layers.into_iter().filter(|layer| layer.count > 0) {
        tile.bytes(3, &layer.bytes());
    }
    tile.0
}

/// The kind and the commands of a geometry.
fn commands(geometry: &Geometry) -> (u64, Vec<u64>) {
    const MOVE: u64 = 1;
    const LINE: u64 = 2;
    const CLOSE: u64 = 7;
    let command = |id: u64, count: usize| id | (count as u64) << 3;
    let (mut out, mut cursor) = (Vec::new(), [0_i32; 2]);
    let mut step = |out: &mut Vec<u64>, to: [i32; 2]| {
        for (at, to) in cursor.iter_mut().zip(to) {
            out.push(zigzag(i64::from(to) - i64::from(*at)));
            *at = to;
        }
    };
    let mut path = |out: &mut Vec<u64>, path: &[[i32; 2]]| {
        out.push(command(MOVE, 1));
        step(out, path[0]);
        out.push(command(LINE, path.len() - 1));
        path[1..].iter().for_each(|&to| step(out, to));
    };
    match geometry {
        Geometry::Point(at) => {
            out.push(command(MOVE, 1));
            step(&mut out, *at);
            (1, out)
        }
        Geometry::Lines(lines) => {
            lines.iter().filter(|line| line.len() > 1).for_each(|line| path(&mut out, line));
            (2, out)
        }
        Geometry::Polygon(rings) => {
            for ring in rings.iter().filter(|ring| ring.len() > 2) {
                path(&mut out, ring);
                out.push(command(CLOSE, 1));
            }
            (3, out)
        }
    }
}

/// A path without points that lie on the way from the one before to the one after.
pub(super) fn straightened(path: impl Iterator<Item = [i32; 2]>) -> Vec<[i32; 2]> {
    let mut out: Vec<[i32; 2]> = Vec::new();
    for point in path {
        if out.last() == Some(&point) {
            continue;
        }
        if let [.., a, b] = out[..] {
            let (to, on) = ([b[0] - a[0], b[1] - a[1]].map(i64::from), [point[0] - b[0], point[1] - b[1]].map(i64::from));
            if to[0] * on[1] == to[1] * on[0] && to[0] * on[0] + to[1] * on[1] > 0 {
                out.pop();
            }
        }
        out.push(point);
    }
    out
}

fn zigzag(number: i64) -> u64 {
    ((number << 1) ^ (number >> 63)) as u64
}

/// A protocol-buffer message.
#[derive(Default)]
struct Message(Vec<u8>);

impl Message {
    fn varint(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.0.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.0.push(number as u8);
    }

    fn whole(&mut self, field: u64, number: u64) {
        self.varint(field << 3);
        self.varint(number);
    }

    fn fixed64(&mut self, field: u64, bits: u64) {
        self.varint(field << 3 | 1);
        self.0.extend(bits.to_le_bytes());
    }

    fn bytes(&mut self, field: u64, bytes: &[u8]) {
        self.varint(field << 3 | 2);
        self.varint(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
    }

    fn packed(&mut self, field: u64, numbers: &[u64]) {
        if !numbers.is_empty() {
            let mut inner = Self::default();
            for &number in numbers {
                inner.varint(number);
            }
            self.bytes(field, &inner.0);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A feature that was read back.
    #[derive(Debug, PartialEq)]
    pub(in crate::tile) struct Read {
        pub layer: String,
        pub id: u64,
        pub kind: u64,
        pub properties: BTreeMap<String, String>,
        pub paths: Vec<Vec<[i64; 2]>>,
    }

    fn varint(bytes: &mut &[u8]) -> u64 {
        let (mut number, mut shift) = (0, 0);
        loop {
            let (byte, rest) = bytes.split_first().expect("a byte");
            *bytes = rest;
            number |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                return number;
            }
        }
    }

    /// The fields of a message: number, whole number, bytes.
    fn fields(mut bytes: &[u8]) -> Vec<(u64, u64, &[u8])> {
        let mut all = Vec::new();
        while !bytes.is_empty() {
            let key = varint(&mut bytes);
            let (number, length) = match key & 7 {
                0 => (varint(&mut bytes), 0),
                1 => (u64::from_le_bytes(bytes[..8].try_into().expect("8 bytes")), 8),
                _ => (0, varint(&mut bytes) as usize),
            };
            all.push((key >> 3, number, &bytes[..length]));
            bytes = &bytes[length..];
        }
        all
    }

    fn numbers(mut bytes: &[u8]) -> Vec<u64> {
        let mut all = Vec::new();
        while !bytes.is_empty() {
            all.push(varint(&mut bytes));
        }
        all
    }

    fn paths(commands: &[u64]) -> Vec<Vec<[i64; 2]>> {
        let unzigzag = |number: u64| (number >> 1) as i64 ^ -((number & 1) as i64);
        let (mut out, mut cursor, mut i) = (Vec::<Vec<[i64; 2]>>::new(), [0, 0], 0);
        while i < commands.len() {
            let (id, count) = (commands[i] & 7, commands[i] >> 3);
            i += 1;
            if id == 7 {
                continue;
            }
            for _ in 0..count {
                cursor = [cursor[0] + unzigzag(commands[i]), cursor[1] + unzigzag(commands[i + 1])];
                i += 2;
                if id == 1 {
                    out.push(Vec::new());
                }
                out.last_mut().expect("a move first").push(cursor);
            }
        }
        out
    }

    fn shown(value: &[u8]) -> String {
        let (field, number, bytes) = fields(value)[0];
        match field {
            1 => String::from_utf8(bytes.to_vec()).expect("text"),
            3 => f64::from_bits(number).to_string(),
            6 => ((number >> 1) as i64 ^ -((number & 1) as i64)).to_string(),
            _ => (number == 1).to_string(),
        }
    }

    /// A tile's features as any reader of the format finds them.
    pub(in crate::tile) fn read(tile: &[u8]) -> Vec<Read> {
        let mut all = Vec::new();
        for (_, _, layer) in fields(tile) {
            let fields_of = fields(layer);
            let list = |field: u64| fields_of.iter().filter(move |entry| entry.0 == field).map(|entry| entry.2);
            let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("text");
            let (keys, values): (Vec<_>, Vec<_>) = (list(3).map(text).collect(), list(4).map(shown).collect());
            let name = text(list(1).next().expect("a name"));
            for feature in list(2) {
                let parts = fields(feature);
                let get = |field: u64| parts.iter().find(|part| part.0 == field).map_or((0, &[][..]), |part| (part.1, part.2));
                let properties = numbers(get(2).1).chunks(2).map(|tag| (keys[tag[0] as usize].clone(), values[tag[1] as usize].clone())).collect();
                all.push(Read { layer: name.clone(), id: get(1).0, kind: get(3).0, properties, paths: paths(&numbers(get(4).1)) });
            }
        }
        all
    }

    /// The examples of the specification, version 2.1, sections 4.3.5 and 4.1.
    #[test]
    fn geometries_are_those_of_the_specification() {
        assert_eq!(commands(&Geometry::Point([25, 17])), (1, vec![9, 50, 34]));
        assert_eq!(commands(&Geometry::Lines(vec![vec![[2, 2], [2, 10], [10, 10]]])), (2, vec![9, 4, 4, 18, 0, 16, 16, 0]));
        assert_eq!(
            commands(&Geometry::Lines(vec![vec![[2, 2], [2, 10], [10, 10]], vec![[1, 1], [3, 5]]])),
            (2, vec![9, 4, 4, 18, 0, 16, 16, 0, 9, 17, 17, 10, 4, 8])
        );
        assert_eq!(commands(&Geometry::Polygon(vec![vec![[3, 6], [8, 12], [20, 34]]])), (3, vec![9, 6, 12, 18, 10, 12, 24, 44, 15]));
    }

    #[test]
    fn what_is_written_can_be_read() {
        let mut layer = Layer::new("lines");
        layer.add(Some(7), &[("name", Value::Text("ä".into())), ("elevation", Value::Int(-300))], &Geometry::Lines(vec![vec![[-64, 5], [4160, 9]]]));
        layer.add(None, &[("index", Value::Bool(true)), ("elevation", Value::Double(0.5))], &Geometry::Point([3, 4]));
        layer.add(None, &[("", Value::Bool(false)); 0], &Geometry::Lines(vec![vec![[1, 1]]]));
        let features = read(&encode(vec![Layer::new("nothing"), layer]));
        assert_eq!(features.len(), 2);
        assert_eq!((features[0].id, features[0].kind, &*features[0].layer, &features[0].paths), (7, 2, "lines", &vec![vec![[-64, 5], [4160, 9]]]));
        assert_eq!((&*features[0].properties["name"], &*features[0].properties["elevation"]), ("ä", "-300"));
        assert_eq!((&*features[1].properties["index"], &*features[1].properties["elevation"]), ("true", "0.5"));
    }
}

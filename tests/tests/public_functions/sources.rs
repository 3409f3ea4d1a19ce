//! The public functions of a crate, read from its sources, and which of them
//! take a number that is no integer, text, or an integer.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use syn::{
    Attribute, Field, FnArg, GenericArgument, GenericParam, Generics, ImplItem, Item, Meta,
    PathArguments, ReturnType, Signature, TraitItem, Type, TypeParamBound, UseTree, Visibility,
};

/// What hostile numbers can be handed to.
#[derive(Debug)]
pub(super) struct Function {
    /// `crate module::Type::name`.
    pub(super) name: String,
    /// Whether any of its parameters can hold such a number; `self` counts where
    /// anybody can put one into it, which no constructor has checked.
    pub(super) takes_floats: bool,
    /// Whether any of its parameters is text, or is made of text and has no type of its own.
    pub(super) takes_text: bool,
    /// Whether any of its parameters is an integer, or is made of some and has no type of
    /// its own; bytes in a row are none.
    pub(super) takes_integers: bool,
}

/// All public functions of the crates at these folders. One function is named
/// once, however many `impl` blocks a generic type has it in.
pub(super) fn functions(crates: &[(&str, &Path)]) -> Vec<Function> {
    let mut sources = Sources::default();
    for (name, folder) in crates {
        let root = folder.join("src");
        sources.read_file(&root.join("lib.rs"), &root, name, true);
    }
    sources.functions()
}

/// Public functions of one file's text, for the tests of the rule.
pub(super) fn functions_of(text: &str) -> Vec<Function> {
    let mut sources = Sources::default();
    let file = syn::parse_file(text).expect("Rust");
    sources.read_items(file.items, Path::new(""), "here", true);
    sources.functions()
}

#[derive(Default)]
struct Sources {
    /// Types of the crates by name: the module of each, and its fields.
    types: HashMap<String, Vec<(String, Vec<Type>)>>,
    /// Those of them that anybody can make of anything: enums, and structures with
    /// public fields alone.
    unchecked: HashSet<(String, String)>,
    /// What `pub use` names: all that is public of private modules.
    exported: HashSet<String>,
    /// Traits, private ones too.
    traits: HashSet<String>,
    found: Vec<Found>,
}

/// A function that is public if the names it is reached by are.
struct Found {
    /// Where: a crate and its modules.
    module: String,
    /// The type or trait that it belongs to.
    of: Option<String>,
    signature: Signature,
    /// Of the `impl` block that it stands in.
    generics: Generics,
    /// Whether its module is reached without `pub use`.
    open: bool,
}

impl Sources {
    fn read_file(&mut self, path: &Path, folder: &Path, module: &str, open: bool) {
        let text =
            std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        self.read_items(file.items, folder, module, open);
    }

    fn read_items(&mut self, items: Vec<Item>, folder: &Path, module: &str, open: bool) {
        for item in items {
            match item {
                Item::Fn(function) if is_public(&function.vis) && !of_tests(&function.attrs) => {
                    self.found.push(Found {
                        module: module.into(),
                        of: None,
                        signature: function.sig,
                        generics: Generics::default(),
                        open,
                    });
                }
                Item::Mod(inner) if !of_tests(&inner.attrs) => {
                    let name = inner.ident.to_string();
                    let folder = folder.join(&name);
                    let module = joined(module, &name);
                    let open = open && is_public(&inner.vis) || self.exported.contains(&name);
                    match inner.content {
                        Some((_, items)) => self.read_items(items, &folder, &module, open),
                        None => self.read_file(&file_of(&folder), &folder, &module, open),
                    }
                }
                Item::Use(of) if is_public(&of.vis) => self.add_names(&of.tree),
                // What reads text is one of the few foreign traits that meet anything.
                Item::Impl(block)
                    if (block.trait_.is_none() || reads_text(&block))
                        && !of_tests(&block.attrs) =>
                {
                    let of_trait = block.trait_.is_some();
                    for item in block.items {
                        if let ImplItem::Fn(function) = item
                            && (of_trait || is_public(&function.vis))
                            && !of_tests(&function.attrs)
                        {
                            self.found.push(Found {
                                module: module.into(),
                                of: last_name(&block.self_ty),
                                signature: function.sig,
                                generics: block.generics.clone(),
                                // A type's functions stand in any module.
                                open: false,
                            });
                        }
                    }
                }
                Item::Trait(described) => {
                    self.traits.insert(described.ident.to_string());
                    if open && is_public(&described.vis) {
                        self.exported.insert(described.ident.to_string());
                    }
                    for item in described.items {
                        if let TraitItem::Fn(function) = item {
                            self.found.push(Found {
                                module: module.into(),
                                of: Some(described.ident.to_string()),
                                signature: function.sig,
                                generics: described.generics.clone(),
                                open: false,
                            });
                        }
                    }
                }
                Item::Struct(made) => {
                    let name = made.ident.to_string();
                    self.add_type(module, &name, &made.fields);
                    let unchecked = made.fields.iter().all(|field| is_public(&field.vis))
                        && !made
                            .attrs
                            .iter()
                            .any(|of| of.path().is_ident("non_exhaustive"));
                    if unchecked {
                        self.unchecked.insert((module.to_owned(), name.clone()));
                    }
                    if open && is_public(&made.vis) {
                        self.exported.insert(name);
                    }
                }
                Item::Enum(made) => {
                    let name = made.ident.to_string();
                    let fields = made.variants.iter().flat_map(|variant| &variant.fields);
                    self.add_type(module, &name, fields);
                    self.unchecked.insert((module.to_owned(), name.clone()));
                    if open && is_public(&made.vis) {
                        self.exported.insert(name);
                    }
                }
                // What it stands for is in it.
                Item::Type(alias) => {
                    let name = alias.ident.to_string();
                    let of_name = self.types.entry(name).or_default();
                    of_name.push((module.to_owned(), vec![*alias.ty]));
                }
                // What it makes is not read here.
                Item::Macro(made) => assert!(
                    !["pub fn", "pub const fn"].iter().any(|made_by| made
                        .mac
                        .tokens
                        .to_string()
                        .contains(made_by)),
                    "{module}: a macro makes a public function: write it out, and have the macro \
                     make what it calls"
                ),
                _ => {}
            }
        }
    }

    fn add_names(&mut self, tree: &UseTree) {
        match tree {
            UseTree::Path(path) => self.add_names(&path.tree),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_names(tree)),
            UseTree::Name(name) => drop(self.exported.insert(name.ident.to_string())),
            UseTree::Rename(name) => drop(self.exported.insert(name.ident.to_string())),
            UseTree::Glob(_) => panic!("`pub use` of all that a module has: name what is public"),
        }
    }

    fn add_type<'a>(
        &mut self,
        module: &str,
        name: &str,
        fields: impl IntoIterator<Item = &'a Field>,
    ) {
        let fields = fields.into_iter().map(|field| field.ty.clone()).collect();
        let of_name = self.types.entry(name.to_owned()).or_default();
        of_name.push((module.to_owned(), fields));
    }

    fn functions(&self) -> Vec<Function> {
        let mut functions: Vec<Function> = Vec::new();
        for found in &self.found {
            let own = found.signature.ident.to_string();
            let reached = found.of.as_ref().unwrap_or(&own);
            if !found.open && !self.exported.contains(reached) {
                continue;
            }
            let name = match &found.of {
                Some(of) => joined(&joined(&found.module, of), &own),
                None => joined(&found.module, &own),
            };
            let takes_floats = self.takes_floats(found);
            let takes = |is: fn(&Type) -> bool| {
                let mut inputs = found.signature.inputs.iter();
                inputs.any(|input| match input {
                    FnArg::Receiver(_) => false,
                    FnArg::Typed(parameter) => is(&parameter.ty),
                })
            };
            let (takes_text, takes_integers) = (takes(is_of_text), takes(is_of_integers));
            match functions.iter_mut().find(|known| known.name == name) {
                Some(known) => {
                    known.takes_floats |= takes_floats;
                    known.takes_text |= takes_text;
                    known.takes_integers |= takes_integers;
                }
                None => functions.push(Function {
                    name,
                    takes_floats,
                    takes_text,
                    takes_integers,
                }),
            }
        }
        functions
    }

    fn takes_floats(&self, found: &Found) -> bool {
        let of_both = [&found.signature.generics, &found.generics];
        let bounds = of_both
            .into_iter()
            .flat_map(|generics| &generics.params)
            .filter_map(|parameter| match parameter {
                GenericParam::Type(of) => Some((of.ident.to_string(), of.bounds.iter().collect())),
                _ => None,
            })
            .collect();
        let context = Context {
            module: &found.module,
            of: found.of.as_deref().unwrap_or_default(),
            bounds,
        };
        found.signature.inputs.iter().any(|input| match input {
            FnArg::Receiver(_) => {
                let of = context.of;
                let is_here = |module: &str| module == found.module;
                let known = self.types.get(of).into_iter().flatten();
                let mut modules = known.map(|(module, _)| module.as_str());
                let here = modules.clone().any(is_here);
                let unchecked = modules.any(|module| {
                    (!here || is_here(module))
                        && self.unchecked.contains(&(module.to_owned(), of.to_owned()))
                });
                unchecked && self.type_holds_floats(of, &context, &mut HashSet::new())
            }
            FnArg::Typed(parameter) => {
                self.holds_floats(&parameter.ty, &context, &mut HashSet::new())
            }
        })
    }

    /// A type holds such a number unless it is known to be made of integers,
    /// truth values, text and bytes alone.
    fn holds_floats(&self, of: &Type, context: &Context, seen: &mut HashSet<String>) -> bool {
        let path = match of {
            Type::Reference(to) => return self.holds_floats(&to.elem, context, seen),
            Type::Slice(of) => return self.holds_floats(&of.elem, context, seen),
            Type::Array(of) => return self.holds_floats(&of.elem, context, seen),
            Type::Paren(of) => return self.holds_floats(&of.elem, context, seen),
            Type::Tuple(of) => {
                return of
                    .elems
                    .iter()
                    .any(|of| self.holds_floats(of, context, seen));
            }
            Type::ImplTrait(of) => {
                return self.bounds_hold(of.bounds.iter(), context, seen);
            }
            Type::TraitObject(of) => {
                return self.bounds_hold(of.bounds.iter(), context, seen);
            }
            Type::Path(path) => path,
            _ => return true,
        };
        let Some(last) = path.path.segments.last() else {
            return true;
        };
        let name = match last.ident.to_string().as_str() {
            "Self" => context.of.to_owned(),
            name => name.to_owned(),
        };
        if WITHOUT_FLOATS.contains(&name.as_str()) {
            return false;
        }
        if let Some(bounds) = context.bounds.get(&name) {
            return bounds.is_empty() || self.bounds_hold(bounds.iter().copied(), context, seen);
        }
        if MADE_OF.contains(&name.as_str()) {
            return arguments(&last.arguments)
                .into_iter()
                .any(|of| self.holds_floats(of, context, seen));
        }
        self.type_holds_floats(&name, context, seen)
    }

    fn type_holds_floats(&self, name: &str, context: &Context, seen: &mut HashSet<String>) -> bool {
        let Some(known) = self.types.get(name) else {
            return true;
        };
        // A name that is another module's may be any of these.
        let here = known.iter().any(|(module, _)| module == context.module);
        known.iter().any(|(module, fields)| {
            let inner = Context {
                module,
                of: name,
                bounds: HashMap::new(),
            };
            let meant = !here || module == context.module;
            // What stands in itself adds nothing.
            let first = meant && seen.insert(format!("{module}::{name}"));
            first && fields.iter().any(|of| self.holds_floats(of, &inner, seen))
        })
    }

    /// What a closure takes comes from us; what it gives, from outside.
    fn bounds_hold<'a>(
        &self,
        mut bounds: impl Iterator<Item = &'a TypeParamBound>,
        context: &Context,
        seen: &mut HashSet<String>,
    ) -> bool {
        bounds.any(|bound| {
            let TypeParamBound::Trait(bound) = bound else {
                return false; // A lifetime.
            };
            let Some(last) = bound.path.segments.last() else {
                return true;
            };
            let name = last.ident.to_string();
            if let PathArguments::Parenthesized(of) = &last.arguments {
                return matches!(&of.output, ReturnType::Type(_, of)
                    if self.holds_floats(of, context, seen));
            }
            // Nobody outside can have a type of a trait without a name there.
            let sealed = self.traits.contains(&name) && !self.exported.contains(&name);
            let plain = WITHOUT_FLOATS.contains(&name.as_str());
            let of_items = MADE_OF.contains(&name.as_str())
                && !arguments(&last.arguments)
                    .into_iter()
                    .any(|of| self.holds_floats(of, context, seen));
            !(sealed || plain || of_items)
        })
    }
}

fn is_of_text(of: &Type) -> bool {
    is_made_of(of, &["str", "String"])
}

/// What is read of bytes is the fuzz targets' matter.
fn is_of_integers(of: &Type) -> bool {
    let is_byte = |of: &Type| matches!(of, Type::Path(of) if of.path.is_ident("u8"));
    match of {
        Type::Reference(to) => is_of_integers(&to.elem),
        Type::Slice(of) if is_byte(&of.elem) => false,
        Type::Array(of) if is_byte(&of.elem) => false,
        _ => is_made_of(of, &INTEGERS),
    }
}

/// Any of these, or slices, tuples and what the standard library makes of them.
fn is_made_of(of: &Type, names: &[&str]) -> bool {
    let of_path = |path: &syn::Path| {
        path.segments.last().is_some_and(|last| {
            let name = last.ident.to_string();
            let wraps = [&MADE_OF[..], &["Into", "AsRef", "IntoIterator", "Cow"]].concat();
            names.contains(&name.as_str())
                || wraps.contains(&name.as_str())
                    && arguments(&last.arguments)
                        .into_iter()
                        .any(|of| is_made_of(of, names))
        })
    };
    let of_bound = |bound: &TypeParamBound| match bound {
        TypeParamBound::Trait(of) => of_path(&of.path),
        _ => false,
    };
    match of {
        Type::Reference(to) => is_made_of(&to.elem, names),
        Type::Slice(of) => is_made_of(&of.elem, names),
        Type::Array(of) => is_made_of(&of.elem, names),
        Type::Tuple(of) => of.elems.iter().any(|of| is_made_of(of, names)),
        Type::ImplTrait(of) => of.bounds.iter().any(of_bound),
        Type::TraitObject(of) => of.bounds.iter().any(of_bound),
        Type::Path(of) => of_path(&of.path),
        _ => false,
    }
}

const INTEGERS: [&str; 10] = [
    "u8", "u16", "u32", "u64", "usize", "i8", "i16", "i32", "i64", "isize",
];

fn reads_text(block: &syn::ItemImpl) -> bool {
    let Some((path, _)) = &block.trait_ else {
        return false;
    };
    path.segments
        .last()
        .is_some_and(|last| last.ident == "FromStr")
}

/// Where a type's name is read.
struct Context<'a> {
    module: &'a str,
    /// What `Self` is.
    of: &'a str,
    /// Of the type parameters.
    bounds: HashMap<String, Vec<&'a TypeParamBound>>,
}

/// Integers, truth values, text, paths and times of the standard library; traits of
/// what has bytes in and out, and of threads.
const WITHOUT_FLOATS: [&str; 34] = [
    "u8",
    "u16",
    "u32",
    "u64",
    "u128",
    "usize",
    "i8",
    "i16",
    "i32",
    "i64",
    "i128",
    "isize",
    "bool",
    "char",
    "str",
    "Formatter",
    "I2c",
    "Read",
    "ReadReady",
    "PhantomData",
    "SevenBitAddress",
    "Decoder",
    "Sized",
    "String",
    "Path",
    "PathBuf",
    "Instant",
    "Duration",
    // Why the system refused something.
    "Error",
    "Write",
    "WriteSeek",
    "Seek",
    "Send",
    "Sync",
];

/// What holds no more than its arguments do.
const MADE_OF: [&str; 8] = [
    "Option",
    "Result",
    "Box",
    "Range",
    "RangeInclusive",
    "Vec",
    "Deque",
    "Iterator",
];

fn arguments(of: &PathArguments) -> Vec<&Type> {
    let PathArguments::AngleBracketed(of) = of else {
        return Vec::new();
    };
    of.args
        .iter()
        .filter_map(|argument| match argument {
            GenericArgument::Type(of) => Some(of),
            GenericArgument::AssocType(of) => Some(&of.ty),
            _ => None,
        })
        .collect()
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// Only `#[cfg(test)]`: what a feature also brings is public.
fn of_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        matches!(&attribute.meta, Meta::List(list)
            if list.path.is_ident("cfg") && list.tokens.to_string() == "test")
    })
}

fn last_name(of: &Type) -> Option<String> {
    match of {
        Type::Path(path) => path.path.segments.last().map(|last| last.ident.to_string()),
        Type::Reference(to) => last_name(&to.elem),
        _ => None,
    }
}

fn joined(module: &str, name: &str) -> String {
    let between = if module.contains(' ') { "::" } else { " " };
    format!("{module}{between}{name}")
}

fn file_of(folder: &Path) -> PathBuf {
    let file = folder.with_extension("rs");
    if file.exists() {
        file
    } else {
        folder.join("mod.rs")
    }
}

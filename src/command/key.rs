//! Keys of a server, made and taken back beside it.

use super::{config, runtime};
use clap::{Args, Subcommand};
use std::{io::Write, path::PathBuf};
use terrane::store::{KeyEntry, Scope, Store};

#[derive(Subcommand)]
pub(crate) enum KeyCommand {
    /// Make a key and print it; it is kept nowhere
    New {
        /// Whose it is, for people
        name: String,
        /// What it is for: read, write (which reads too) or admin (which does all)
        #[arg(long, default_value_t = Scope::Write)]
        scope: Scope,
        #[command(flatten)]
        folder: Folder,
    },
    /// Show all keys without their secrets
    List {
        #[command(flatten)]
        folder: Folder,
    },
    /// Take a key back
    Revoke {
        /// Its id, as `terrane key list` shows it
        id: String,
        #[command(flatten)]
        folder: Folder,
    },
}

#[derive(Args)]
pub(crate) struct Folder {
    /// Folder of the server's data [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

impl Folder {
    async fn open(self) -> anyhow::Result<Store> {
        let folder = self.data.map_or_else(|| config(None).map(|config| config.server.data), Ok)?;
        Ok(Store::open_beside(&folder).await?)
    }
}

pub(crate) fn key(command: KeyCommand) -> anyhow::Result<()> {
    let mut out = std::io::stdout();
    runtime()?.block_on(async {
        match command {
            KeyCommand::New { name, scope, folder } => {
                let (_, secret) = folder.open().await?.add_key(&name, scope).await?;
                Ok(writeln!(out, "{secret}")?)
            }
            KeyCommand::List { folder } => {
                for KeyEntry { id, name, scope, time, .. } in folder.open().await?.keys().await? {
                    writeln!(out, "{id}  {scope:<5}  {time}  {name}")?;
                }
                Ok(())
            }
            KeyCommand::Revoke { id, folder } => Ok(folder.open().await?.revoke_key(&id).await?),
        }
    })
}

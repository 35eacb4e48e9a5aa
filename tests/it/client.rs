//! Requests to a server without sockets, each held to the `OpenAPI` description.

use axum::{
    body::{Body, Bytes},
    http::{HeaderMap, Method, Request, StatusCode},
};
use serde_json::Value;
use tempfile::TempDir;
use terrane::server::{App, Config, Front, openapi};
use tower::ServiceExt;

/// What requests call the server unless they say otherwise.
pub(crate) const HOST: &str = "localhost:8080";

pub(crate) struct Answer {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl Answer {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&self.body)))
    }

    pub(crate) fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    /// `status: detail of each error`, or the problem's own detail.
    pub(crate) fn problem(&self) -> String {
        assert_eq!(self.header("content-type"), "application/problem+json");
        let problem = self.json();
        assert_eq!(problem["status"], self.status.as_u16());
        let place = |error: &Value| format!("{}: {}", error["pointer"].as_str().or(error["parameter"].as_str()).unwrap(), error["detail"].as_str().unwrap());
        let errors: Vec<_> = problem["errors"].as_array().into_iter().flatten().map(place).collect();
        let detail = problem["detail"].as_str().unwrap().to_owned();
        format!("{} {}", self.status.as_u16(), if errors.is_empty() { detail } else { errors.join("; ") })
    }
}

pub(crate) struct Client {
    pub app: App,
    front: Front,
    description: Value,
    folder: TempDir,
}

impl Client {
    pub(crate) async fn new() -> Self {
        Self::with(|_| {}).await
    }

    pub(crate) async fn with(change: impl Fn(&mut Config)) -> Self {
        Self::over(tempfile::tempdir().unwrap(), change).await
    }

    /// A server over a folder that may hold worlds already.
    pub(crate) async fn over(folder: TempDir, change: impl Fn(&mut Config)) -> Self {
        let mut config = Config::default();
        config.server.data = folder.path().to_path_buf();
        change(&mut config);
        let app = App::load(&config).await.unwrap();
        let description = serde_json::to_value(openapi()).unwrap();
        Self { front: Front::new(app.clone()), app, description, folder }
    }

    /// Starts again over the same folder, with empty caches.
    pub(crate) async fn restart(self, change: impl Fn(&mut Config)) -> Self {
        let Self { app, front, folder, .. } = self;
        app.close().await;
        // The last holders of the folder's lock.
        drop((app, front));
        Self::over(folder, change).await
    }

    /// Where it keeps what it stores.
    pub(crate) fn folder(&self) -> &std::path::Path {
        self.folder.path()
    }

    pub(crate) async fn get(&self, path: &str) -> Answer {
        self.send(Method::GET, path, &[], "").await
    }

    pub(crate) async fn put(&self, path: &str, body: &str) -> Answer {
        self.send(Method::PUT, path, &[], body.to_owned()).await
    }

    pub(crate) async fn send(&self, method: Method, path: &str, headers: &[(&str, &str)], body: impl Into<Body>) -> Answer {
        let mut request = Request::builder().method(&method).uri(path);
        if !headers.iter().any(|(name, _)| *name == "host") {
            request = request.header("host", HOST);
        }
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let response = self.front.clone().oneshot(request.body(body.into()).unwrap()).await.unwrap();
        let (parts, body) = response.into_parts();
        let body = axum::body::to_bytes(body, usize::MAX).await.unwrap();
        let answer = Answer { status: parts.status, headers: parts.headers, body };
        self.check_contract(&method, path, &answer);
        answer
    }

    /// An answer's status and media type must be among those described.
    fn check_contract(&self, method: &Method, path: &str, answer: &Answer) {
        let path = path.split('?').next().unwrap();
        let Some(item) = self.described(path) else {
            assert_eq!(answer.status, StatusCode::NOT_FOUND, "{path} is not described");
            return;
        };
        let name = if method == Method::HEAD { "get".to_owned() } else { method.as_str().to_lowercase() };
        let Some(operation) = item.get(&name) else {
            assert!(answer.status == StatusCode::METHOD_NOT_ALLOWED || method == Method::OPTIONS, "{method} {path} is not described: {}", answer.status);
            return;
        };
        let response = &operation["responses"][answer.status.as_str()];
        assert!(response.is_object(), "{method} {path}: {} is not described", answer.status);
        if let Some(content) = response["content"].as_object() {
            let media_type = answer.header("content-type").split(';').next().unwrap();
            assert!(content.contains_key(media_type), "{method} {path}: {} as {media_type:?} is not described", answer.status);
        }
    }

    /// The description of the path that matches, fixed segments before parameters.
    pub(crate) fn described(&self, path: &str) -> Option<&Value> {
        let parts: Vec<_> = path.split('/').collect();
        let fits = |template: &&String| {
            let template: Vec<_> = template.split('/').collect();
            template.len() == parts.len()
                && template.iter().zip(&parts).all(|(template, part)| template.starts_with('{') && !part.is_empty() || template == part)
        };
        let paths = self.description["paths"].as_object().unwrap();
        let template = paths.keys().filter(fits).min_by_key(|template| template.matches('{').count())?;
        Some(&paths[template])
    }
}
